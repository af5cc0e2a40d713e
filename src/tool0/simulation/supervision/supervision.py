"""Supervision of all motions: path errors, arrival, contact forces and limits.

An arm is checked every 8 ms of simulated time if its safety limits are enabled or if a
program moves it.  In the compliant modes (force mode, freedrive), the motion of a
program is not checked.  The checks are not part of the tick, and do not depend on
subscribers.  Violations of a ROS controller's own tolerances are explained in the same
way.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter, sub
from typing import Final, NamedTuple, final

from tool0.description.model import RECOVERABLE, Interface
from tool0.description.scene_state import contacts_text
from tool0.hardware.engine import JointState, joint_selector
from tool0.protocol.goals import Goal, GripperResult, Result
from tool0.sensing.stalls import external_contacts
from tool0.simulation.arms.arm import Arm
from tool0.simulation.core import Core
from tool0.simulation.supervision.causes import Causes, TrackedJoint
from tool0.simulation.supervision.contact_forces import ContactForces

CHECK_PERIOD: Final = 0.1
"""Simulated time between complete checks of the joints [s].  The period is the time
within which a UR robot detects a joint beyond its limit (user manual of the UR5/CB3,
5.1)."""
LIMIT_MARGIN: Final = RECOVERABLE
"""Tolerated distance beyond a joint's limit [rad].  Within the margin, an arm may rest
and can be moved back.  The trueness of the joint positions of a UR robot is 0.02
rad."""
SUSPICIOUS: Final = 0.5
"""Fraction of the largest lag above which contacts are read, since an engine may record
contacts only after the first call."""


class Failure(NamedTuple):
    """An arm that must stop, and the reason."""

    arm: Arm
    reason: str
    is_beyond_limits: bool
    """Whether a safety limit of the arm is exceeded; otherwise, the arm's motion has
    failed."""


@final
class Supervision:
    """Finds and explains failures.

    Only the thread that executes the tick may use ``Supervision``.
    """

    def __init__(self, core: Core) -> None:
        self._core = core
        self._watches = tuple(_Watch(arm, core) for arm in core.arms)

    def failures(self) -> list[Failure]:
        """Return the arms that must stop, in the order of the model.

        A call to ``failures`` takes 2 µs for each monitored arm if the arm has no
        failures and no contacts.
        """
        found = []
        for watch in self._watches:
            if reason := watch.excess():
                found.append(Failure(watch.arm, reason, is_beyond_limits=True))
            elif reason := watch.lost():
                found.append(Failure(watch.arm, reason, is_beyond_limits=False))
        return found

    def forget(self) -> None:
        """Clear the forces, for example after a reset."""
        for watch in self._watches:
            watch.forget()

    # ---- outcomes of goals ----------------------------------------------------------

    def explained(self, goal: Goal, result: Result) -> Result:
        """Return a result with the reason why the joints stopped, if it is known."""
        if isinstance(result, GripperResult):
            return self._with_grip(goal, result) if result.stalled else result
        if not result.is_violation:
            return result
        why = self._cause(self._core.manager.spec(goal.controller).joints)
        if not why:
            return result
        return replace(result, error_string=f"{result.error_string}; {why}")

    def gripper_obstacle(self, joint: str) -> str:
        """Return the reason why the gripper with the driven ``joint`` has stopped."""
        touching = self._touching((self._core.model.joint(joint).parent,))
        return touching or "no contact: its stop, or the load"

    def _with_grip(self, goal: Goal, result: GripperResult) -> GripperResult:
        """Return the result of a stalled gripper, with the reason for the stall."""
        (joint,) = self._core.manager.spec(goal.controller).joints
        holds = any(
            gripper.joint == joint and gripper.name in self._core.grip_contacts.gripping
            for gripper in self._core.model.grippers
        )
        why = self.gripper_obstacle(joint)
        text = f"stopped by what it holds ({why})" if holds else f"blocked ({why})"
        return replace(result, holds=holds, error_string=text)

    def _cause(self, names: tuple[str, ...]) -> str:
        """Return the known reasons why joints are not at their setpoints."""
        core = self._core
        for watch in self._watches:
            joints = [joint for joint in watch.causes.joints if joint.name in names]
            if joints:
                joint, _ = _furthest(joints, core.wanted_positions(), core.state)
                return watch.causes.known(joint, joints, core.state)
        return self._touching(core.model.joint(name).child for name in names)

    def _touching(self, roots: Iterable[str]) -> str:
        """Return the contacts of the links in the subtrees at ``roots``.

        The result is empty if there are no contacts.
        """
        core = self._core
        groups = [frozenset(core.model.links_from(root)) for root in roots]
        contacts = core.engine.world.contacts()
        return contacts_text(external_contacts(groups, contacts))


@final
class _Watch:
    """Monitors one arm."""

    def __init__(self, arm: Arm, core: Core) -> None:
        self.arm, self._core = arm, core
        self.causes = Causes(arm.parts, core)
        self._forces = ContactForces(arm.parts, core.model, core.engine.world)
        joints = self.causes.joints
        self._select = joint_selector([joint.number for joint in joints])
        self._least_error = min((joint.error for joint in joints), default=math.inf)
        self._running: object = None
        """Controllers that were running when the claims were last read."""
        self._is_servoed = False
        """Whether all joints are position-controlled by servos."""
        self.forget()

    def forget(self) -> None:
        """Clear the forces, for example after a reset."""
        self._checked = -math.inf
        """Time at which all joints were last checked [s]."""
        self._forces.forget()

    # ---- safety limits --------------------------------------------------------------

    def excess(self) -> str:
        """Describe the enabled safety limit that is exceeded.

        The result is empty if no safety limit is exceeded.
        """
        box, state = self.arm.box.state, self._core.state
        if not (box.safety_limits.is_enabled and box.may_move):
            return ""
        if reason := self._forces.excess(state.time, box):
            return reason
        is_due = not 0.0 <= state.time - self._checked < CHECK_PERIOD
        if is_due or (self._are_servoed() and not self._lag() <= self._least_error):
            self._checked = state.time
            wanted = self._core.wanted_positions()
            return self._beyond_limit(wanted) or self._off_path(wanted)
        return ""

    def _are_servoed(self) -> bool:
        """Return whether all joints are position-controlled by servos.

        If joints are controlled by efforts or velocities, the setpoints differ from the
        commands and are checked only every ``CHECK_PERIOD``.
        """
        running, hardware = self._core.manager.running_controllers, self._core.hardware
        if running is not self._running:
            claimed, self._running = hardware.claimed, running
            self._is_servoed = all(
                claimed.get(joint.name) is Interface.POSITION
                for joint in self.causes.joints
            )
        return self._is_servoed

    def _beyond_limit(self, wanted: Mapping[str, float]) -> str:
        """Describe the joint that is commanded beyond a limit.

        The result is empty if no joint is commanded beyond a limit.
        """
        for joint in self.causes.joints:
            if (target := wanted.get(joint.name)) is None:
                continue
            beyond = max(joint.lower - target, target - joint.upper)
            if not beyond <= LIMIT_MARGIN:
                return (
                    f"joint '{joint.name}' is commanded to {target:.4g} rad; its "
                    f"limits are [{joint.lower:.4g}, {joint.upper:.4g}] rad"
                )
        return ""

    # ---- the motion of a program ----------------------------------------------------

    def lost(self) -> str:
        """Return the reason why a program's motion has failed.

        The result is empty if the motion has not failed.
        """
        if not self.arm.motion.is_taken or self.arm.box.state.motion_failure:
            return ""
        controller, state = self.arm.motion.controller, self._core.state
        if controller.is_compliant:
            return ""
        lag, joints = self._lag(), self.causes.joints
        is_suspicious = not lag <= SUSPICIOUS * self._least_error
        is_overdue = controller.is_overdue(lag, state.time)
        if not (is_suspicious or is_overdue):
            return ""
        command = self._core.newest_command()
        wanted = {joint.name: command[joint.number] for joint in joints}
        self.causes.watch(state.time)
        if reason := self._off_path(wanted):
            return reason
        if is_overdue:
            joint, error = _furthest(joints, wanted, state)
            return (
                f"joint '{joint.name}' is {error:.3f} rad from the end of its path "
                f"({self._cause(joint)})"
            )
        return ""

    # ---- shared functions -----------------------------------------------------------

    def _lag(self) -> float:
        """Return the largest distance of a joint from its command [rad]."""
        core = self._core
        commands = self._select(core.newest_command())
        errors = map(sub, commands, self._select(core.state.position))
        return max(map(abs, errors), default=0.0)

    def _off_path(self, wanted: Mapping[str, float]) -> str:
        """Describe a joint that is too far from its setpoint.

        The result is empty if no joint is too far from its setpoint.
        """
        position = self._core.state.position
        for joint in self.causes.joints:
            here = position[joint.number]
            error = abs(wanted.get(joint.name, here) - here)
            if not error <= joint.error:
                return (
                    f"joint '{joint.name}' is {error:.3f} rad off its path, more than "
                    f"{joint.error:.3f} rad ({self._cause(joint)})"
                )
        return ""

    def _cause(self, joint: TrackedJoint) -> str:
        return self.causes.of(joint, self._core.state)


def _furthest(
    joints: Sequence[TrackedJoint], wanted: Mapping[str, float], state: JointState
) -> tuple[TrackedJoint, float]:
    """Return the joint with the largest distance from its setpoint.

    The second item of the result is the distance [rad].
    """
    errors = []
    for joint in joints:
        here = state.position[joint.number]
        errors.append((joint, abs(wanted.get(joint.name, here) - here)))
    return max(errors, key=itemgetter(1))
