"""Torque mode: a program drives the joints of an arm with torques of its own.

The drives add what balances gravity, and compensate a part of the friction.  The
program is responsible for the rest: a joint that is too fast, or that could not stop
before the end of its range any more, is a violation, after which the brakes hold.

Servos hide what is in a drive.  Under torques, its rotor counts
(``RobotHardware.rotors``) and the friction of its gear, without which no torque could
be chosen as on a real arm: with a constant one, a joint reaches a speed, not a limit.
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
"""Part of a joint's largest speed at which it is too fast: the drives allow no more
than all of it."""
BRAKING: Final = 0.5
"""Part of the deceleration of a joint that brakes alone with all its torque but its
weight, which it has for certain: other joints fling it."""
RESTING: Final = 0.02
"""Slower joints do not leave their range [rad/s]."""
SLOW: Final = 0.02
"""Below this speed, dry friction fades [rad/s]."""
DRY_FRICTION: Final = 0.05
"""Dry friction of a gear, as a part of the largest torque of its joint: 7.5 N·m in a
UR5e's shoulder, 1.4 N·m in its wrists.  A guess: no datasheet has a value."""
VISCOUS_FRICTION: Final = 0.08
"""Viscous friction of a gear for the largest torque of its joint [s]: 12 and 2.2
N·m·s/rad.  A guess, too."""
WARM: Final = 0.6
"""Part of the viscous friction that the model of the drive knows, which must not
compensate too much where the lubricant is warm.  A guess."""
STABLE: Final = 0.3
"""Largest product of a rate by which friction slows a joint and the step."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueCommand:
    """Torques of an arm's joints, from base to flange, and how long they act."""

    torques: Sequence[float]
    """Torques in addition to gravity [N·m]."""
    viscous_scale: Sequence[float]
    """Compensated part of the viscous friction of each joint, 0 … 1."""
    coulomb_scale: Sequence[float]
    """Compensated part of the dry friction of each joint, 0 … 1."""
    until: float
    """Simulated time at which torque mode ends without a further command [s]."""


@final
class TorqueMode:
    """Turns the torques of a program into efforts, and watches the joints."""

    def __init__(
        self, joints: Sequence[Joint], model: ArmModel, select: JointSelector
    ) -> None:
        """Expect a command; ``select`` takes the arm's joints out of a state."""
        self._joints, self._model, self._select = joints, model, select
        self._rotors = model.rotors()
        self._command: TorqueCommand | None = None

    def aim(self, command: TorqueCommand) -> None:
        """Apply torques from now on.

        Raises:
            ControlError: If one is more than its drive has; nothing has changed then.
        """
        for joint, torque in zip(self._joints, command.torques, strict=True):
            if not abs(torque) <= joint.limits.effort:
                raise ControlError(
                    f"the torque {torque:.4g} N·m of '{joint.name}' is beyond its "
                    f"limit of {joint.limits.effort:.4g} N·m"
                )
        self._command = command

    def is_over(self, now: float) -> bool:
        """Return whether no command came in time; ``now`` is [s]."""
        return self._command is None or now >= self._command.until

    def efforts(self, state: JointState, dt: float) -> list[float]:
        """Return the efforts of the joints in the coming step of ``dt`` [N·m]."""
        command = self._command
        assert command is not None  # torque mode starts with one
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
        """Return which limit a joint exceeds, or is about to; empty if none does.

        It is called in each tick, which takes ``period`` [s].
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
            way = left - speed * period  # that is left for braking
            if 2.0 * brake * way <= mass * speed * speed:
                return (
                    f"joint '{joint.name}' is at {q:.4g} rad and turns with {v:.3g} "
                    f"rad/s; it can stop within its limits [{limits.lower:.4g}, "
                    f"{limits.upper:.4g}] only now"
                )
        return ""
