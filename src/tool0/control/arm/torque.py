"""Torque mode, in which a program commands the joint torques of an arm.

The drives add the torques that balance gravity, and compensate part of the friction.
The program is responsible for all other torques.  A violation occurs if a joint becomes
too fast, or if it would soon be unable to stop before the end of its range.  After a
violation, the brakes engage.

Position servos hide a drive's inner dynamics.  In torque mode, the rotor's inertia
(``RobotHardware.rotors``) and the friction of the gear are relevant.  Without simulated
friction, torques suitable for a real arm would not work in the simulation: on a real
arm, a joint under a constant torque settles at a constant speed instead of accelerating
up to its limit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import add
from typing import Final, final

from tool0.control.arm.model import ArmModel
from tool0.description.model import Joint
from tool0.errors import ControlError
from tool0.hardware.engine import JointSelector, JointState

FASTEST: Final = 0.99
"""Fraction of a joint's largest speed at which the joint is considered too fast.  The
drives do not allow more than the largest speed."""
BRAKING: Final = 0.5
"""Fraction of the nominal deceleration that is guaranteed for a joint.  The nominal
deceleration assumes that only this joint brakes, with its full torque minus the gravity
load; the motion of other joints may reduce the deceleration."""
RESTING: Final = 0.02
"""Speed below which a joint is assumed to stay within its range [rad/s]."""
SLOW: Final = 0.02
"""Speed below which the dry friction is proportional to the speed [rad/s]."""
DRY_FRICTION: Final = 0.05
"""Dry friction of a gear, as a fraction of its joint's largest torque: 7.5 N·m in the
shoulder and 1.4 N·m in the wrists of a UR5e.  The value is an estimate, since
datasheets do not specify the friction."""
VISCOUS_FRICTION: Final = 0.08
"""Viscous friction of a gear, relative to its joint's largest torque [s]: 12 N·m·s/rad
in the shoulder and 2.2 N·m·s/rad in the wrists of a UR5e.  The value is an estimate."""
WARM: Final = 0.6
"""Fraction of the viscous friction that the drive's friction model covers.  The model
must not overcompensate when the lubricant is warm.  The value is an estimate."""
STABLE: Final = 0.3
"""Largest product of the rate at which friction slows a joint [1/s] and the physics
step [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueCommand:
    """Torques of an arm's joints, from the base to the flange, with an expiry time."""

    torques: Sequence[float]
    """Torques in addition to the gravity compensation [N·m]."""
    viscous_scale: Sequence[float]
    """Compensated fraction of each joint's viscous friction, 0 … 1."""
    coulomb_scale: Sequence[float]
    """Compensated fraction of each joint's dry friction, 0 … 1."""
    until: float
    """Simulated time at which torque mode ends unless another command is received
    [s]."""


@final
class TorqueMode:
    """Converts a program's torques to joint efforts, and monitors the joints."""

    def __init__(
        self, joints: Sequence[Joint], model: ArmModel, select: JointSelector
    ) -> None:
        """Initialize without a command.

        ``select`` extracts the values of the arm's joints from a state.
        """
        self._joints, self._model, self._select = joints, model, select
        self._rotors = model.rotors()
        self._command: TorqueCommand | None = None

    def aim(self, command: TorqueCommand) -> None:
        """Apply the torques of a command, starting now.

        Raises:
            ControlError: If a torque exceeds its drive's limit; in this case, nothing
                changes.
        """
        for joint, torque in zip(self._joints, command.torques, strict=True):
            if not abs(torque) <= joint.limits.effort:
                raise ControlError(
                    f"the torque {torque:.4g} N·m of '{joint.name}' is beyond its "
                    f"limit of {joint.limits.effort:.4g} N·m"
                )
        self._command = command

    def is_over(self, now: float) -> bool:
        """Return whether the last command has expired at ``now`` [s]."""
        return self._command is None or now >= self._command.until

    def efforts(self, state: JointState, dt: float) -> list[float]:
        """Return the joint efforts for the next step of ``dt`` seconds [N·m]."""
        command = self._command
        assert command is not None  # torque mode starts with a command
        masses, weights = self._model.dynamics(state)
        rows = zip(
            self._joints,
            map(add, masses.diagonal().tolist(), self._rotors),
            weights.tolist(),
            command.torques,
            self._select(state.velocity),
            command.viscous_scale,
            command.coulomb_scale,
            strict=True,
        )
        efforts = []
        for joint, mass, weight, torque, v, viscous, coulomb in rows:
            most = joint.limits.effort if joint.limits.effort < math.inf else 0.0
            stiff = STABLE * mass / dt
            damping = (1.0 - WARM * viscous) * VISCOUS_FRICTION * most
            dry = (1.0 - coulomb) * DRY_FRICTION * most
            slow = max(SLOW, dry / stiff)
            gear = min(damping, stiff) * v + dry * min(max(v / slow, -1.0), 1.0)
            own = viscous * joint.damping * v
            own += coulomb * joint.friction * min(max(v / SLOW, -1.0), 1.0)
            efforts.append(weight + torque - gear + own)
        return efforts

    def violation(self, state: JointState, period: float) -> str:
        """Describe the limit that a joint exceeds or is about to exceed.

        The result is empty if there is no violation.  The tick calls ``violation``; a
        tick takes ``period`` [s].
        """
        masses, weights = self._model.dynamics(state)
        position, velocity = self._select(state.position), self._select(state.velocity)
        rows = zip(
            self._joints,
            position,
            velocity,
            masses.diagonal().tolist(),
            weights.tolist(),
            strict=True,
        )
        for joint, q, v, mass, weight in rows:
            limits, speed = joint.limits, abs(v)
            if speed >= FASTEST * limits.velocity:
                return (
                    f"joint '{joint.name}' turns with {v:.3g} rad/s; its largest speed "
                    f"is {limits.velocity:.3g} rad/s"
                )
            if speed <= RESTING:
                continue
            left = limits.upper - q if v > 0.0 else q - limits.lower
            brake = BRAKING * max(limits.effort - abs(weight), 0.1 * limits.effort)
            way = left - speed * period  # distance left for braking
            if 2.0 * brake * way <= mass * speed * speed:
                return (
                    f"joint '{joint.name}' is at {q:.4g} rad and turns with {v:.3g} "
                    f"rad/s; it can stop within its limits [{limits.lower:.4g}, "
                    f"{limits.upper:.4g}] only now"
                )
        return ""
