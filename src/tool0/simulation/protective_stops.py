"""What stops an arm by itself: a path error, a contact's force, a joint's limit.

A UR derives the force from the currents of its joints; here the engine's contacts have
it.  They are read every 8 ms, only for arms whose safety limits are enabled: the tick
pays nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import sub
from typing import Final, final

from tool0.control.manager import ControllerManager
from tool0.description.model import RECOVERABLE, Interface, RobotModel
from tool0.description.parts import ArmParts, find_arms
from tool0.hardware.engine import JointState, World, joint_selector
from tool0.hardware.payload import modelled_payload
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.state import Contact, contacts_text
from tool0.sensing.stalls import external_contacts
from tool0.simulation.path_errors import PathErrors

DETECTION_TIME: Final = 0.1
"""Time constant of the low-pass filter of contact forces [s]: an impact is no clamping.
25 N above the limit are detected after 0.2 s; a UR's force limit has a trueness of 25 N
and a detection time of 250 ms (user manual of the UR5/CB3, 5.1)."""
CHECK_PERIOD: Final = 0.1
"""Simulated time between complete checks of the joints [s]: that in which a UR detects
a joint beyond its limit (the same table)."""
_NEGLIGIBLE: Final = 0.1
"""[N]"""
LIMIT_MARGIN: Final = RECOVERABLE
"""Distance beyond a joint's limit that is tolerated [rad]: from there, an arm may rest,
and be moved back.  (The trueness of a UR's joint positions is 0.02 rad.)"""


@final
@dataclass(slots=True)
class _Body:
    """Links that move as one, or the whole tool."""

    name: str
    links: frozenset[str]
    force: list[float] = field(default_factory=lambda: [0.0] * 3)
    """Filtered force that it exerts [N]."""


@final
class ProtectiveStops:
    """Looks for reasons to stop an arm.  Only the thread of the tick may use it."""

    def __init__(
        self,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
        world: World,
    ) -> None:
        self._arms = {
            name: _Arm(arm, model, hardware, manager, world)
            for name, arm in find_arms(model).items()
        }
        self._boxes: tuple[ControlBoxState, ...] = ()
        self._watched: tuple[tuple[_Arm, ControlBoxState], ...] = ()

    def look(
        self,
        boxes: tuple[ControlBoxState, ...],
        state: JointState,
        command: list[float],
    ) -> list[tuple[str, str]]:
        """Return the arms to stop, with the reasons.

        Args:
            boxes: The control boxes: the same tuple until one changes.
            state: Measured.
            command: The last command of each joint, in the unit of its interface.
        """
        if boxes is not self._boxes:
            self._boxes = boxes
            self._watched = tuple(
                (self._arms[box.arm], box)
                for box in boxes
                if box.safety_limits.is_enabled and box.may_move
            )
        found = []
        for arm, box in self._watched:
            reason = arm.look(state, command, box)
            if reason:
                found.append((box.arm, reason))
        return found

    def forget(self) -> None:
        """Forget forces, as after a reset."""
        for arm in self._arms.values():
            arm.forget()


@final
class _Arm:
    """The joints and the bodies of one arm."""

    def __init__(
        self,
        arm: ArmParts,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
        world: World,
    ) -> None:
        self._hardware, self._manager, self._world = hardware, manager, world
        self._path_errors = PathErrors(arm, model, hardware, manager, world)
        self._joints = self._path_errors.joints
        moved = [frozenset(model.links_from(joint.child)) for joint in arm.joints]
        further = [*moved[1:], frozenset[str]()]
        names = [*(joint.child for joint in arm.joints[:-1]), arm.flange]
        self._tool_mass = modelled_payload(model, arm.flange).mass
        self._links = moved[0]
        """All but the base."""
        self._bodies = [
            _Body(name, links - rest)
            for name, links, rest in zip(names, moved, further, strict=True)
        ]
        self._running: object = None
        """The running controllers when the claims were looked up."""
        self._is_servoed = False
        """Whether servos drive all joints to positions."""
        self._select = joint_selector([joint.number for joint in self._joints])
        self._least_error = min((j.error for j in self._joints), default=math.inf)
        self.forget()

    def forget(self) -> None:
        """Forget forces, as after a reset."""
        self._last = self._checked = -math.inf
        """When forces were filtered, and all joints were checked [s]."""
        self._is_loaded = False
        """Whether a filtered force is not zero."""
        for body in self._bodies:
            body.force = [0.0] * 3

    def look(
        self, state: JointState, command: list[float], box: ControlBoxState
    ) -> str:
        """Return why the arm must stop; empty if it need not.

        It takes 2 µs unless something is wrong, or the arm touches something.
        """
        passed, self._last = state.time - self._last, state.time
        if self._is_loaded or self._world.is_touched(self._links):
            share = 1.0 - math.exp(-passed / DETECTION_TIME) if passed >= 0.0 else 1.0
            if reason := self._force_reason(share, box):
                return reason
        is_due = not 0.0 <= state.time - self._checked < CHECK_PERIOD
        if is_due or self._is_off(state, command):
            self._checked = state.time
            return self._joint_reason(state, command)
        return ""

    def _is_off(self, state: JointState, command: list[float]) -> bool:
        """Return whether a joint may be too far from the position it is sent to."""
        running = self._manager.running_controllers
        if running is not self._running:
            claimed, self._running = self._hardware.claimed, running
            self._is_servoed = all(
                claimed.get(joint.name) is Interface.POSITION for joint in self._joints
            )
        if not self._is_servoed:
            return False  # by efforts or velocities: the setpoints are checked at times
        errors = map(sub, self._select(command), self._select(state.position))
        return not max(map(abs, errors)) <= self._least_error

    def _joint_reason(self, state: JointState, command: list[float]) -> str:
        """Return which joint is beyond a limit, or off its path."""
        wanted = wanted_positions(self._hardware, self._manager, command)
        for joint in self._joints:
            target = wanted.get(joint.name)
            if target is None:
                continue
            beyond = max(joint.lower - target, target - joint.upper)
            if not beyond <= LIMIT_MARGIN:
                return (
                    f"joint '{joint.name}' is commanded to {target:.4g} rad; its "
                    f"limits are [{joint.lower:.4g}, {joint.upper:.4g}] rad"
                )
            error = abs(target - state.position[joint.number])
            if not error <= joint.error:
                return self._path_errors.off_path(joint, error, state)
        return ""

    def _force_reason(self, share: float, box: ControlBoxState) -> str:
        """Filter the forces on all bodies; return which one is too large."""
        touching, largest = self._world.contacts(), box.safety_limits.force
        carried = box.payload.mass - self._tool_mass
        self._is_loaded = False
        for body in self._bodies:
            force, filtered = _exerted(body.links, touching), body.force
            if body is self._bodies[-1] and any(force):  # it carries the payload
                for k, g in enumerate(self._world.gravity):
                    force[k] += carried * g
            for k in range(3):
                filtered[k] += share * (force[k] - filtered[k])
            strength = math.hypot(*filtered)
            self._is_loaded |= strength > _NEGLIGIBLE
            if not strength <= largest:
                why = contacts_text(external_contacts(body.links, touching))
                return (
                    f"contact force of {strength:.0f} N at '{body.name}', more than "
                    f"{largest:.0f} N ({why})"
                )
        return ""


def wanted_positions(
    hardware: RobotHardware, manager: ControllerManager, command: Sequence[float]
) -> Mapping[str, float]:
    """Return the setpoint of each joint that is moved by position [rad | m]."""
    wanted = {
        name: command[hardware.index[name]]
        for name, interface in hardware.claimed.items()
        if interface is Interface.POSITION
    }
    for setpoint in manager.setpoints().values():
        models, splines = setpoint.joint_models, setpoint.splines
        for joint, spline in zip(models, splines, strict=True):
            wanted[joint.name] = spline.sample(setpoint.time).position
    return wanted


def _exerted(links: frozenset[str], touching: Sequence[Contact]) -> list[float]:
    """Return the resultant force that ``links`` exert on everything else [N].

    What they grip cancels, but for its weight, inertia and own contacts.
    """
    total = [0.0, 0.0, 0.0]
    for contact in touching:
        is_first = contact.first in links
        if is_first != (contact.second in links):
            sign = 1.0 if is_first else -1.0
            for k in range(3):
                total[k] += sign * contact.force[k]
    return total
