"""Whether the arms that programs move follow their setpoints, and arrive.

It is looked at every 8 ms of simulated time, for every mode of ``ArmMotionController``
but those that give way (force mode, freedrive): nothing is computed in the tick, and
nothing depends on who reads.
"""

from __future__ import annotations

from collections.abc import Iterator
from operator import sub
from typing import Final, NamedTuple, final

from tool0.control.arm_motion import ArmMotionController
from tool0.description.model import Joint, JointLimits, RobotModel
from tool0.description.parts import ArmParts, find_arms
from tool0.hardware.engine import JointState, World, joint_selector
from tool0.hardware.robot_hardware import RobotHardware
from tool0.runtime.arm_motions import ArmMotions
from tool0.sensing.stalls import LARGEST_LAG, contacts_text, external_contacts

SUSPICIOUS: Final = 0.5
"""Part of the largest lag from which contacts are read: an engine may record them only
after the first call."""


@final
class TrackedJoint(NamedTuple):
    """A joint that is to be where it is sent."""

    name: str
    number: int
    """In the engine's order."""
    error: float
    """Largest distance from the setpoint [rad]."""
    links: frozenset[str]
    """All that it moves."""

    @staticmethod
    def of(
        joint: Joint, limits: JointLimits, model: RobotModel, hardware: RobotHardware
    ) -> TrackedJoint:
        """Return a joint with these limits."""
        links = frozenset(model.links_from(joint.child))
        largest = LARGEST_LAG * limits.velocity
        return TrackedJoint(joint.name, hardware.index[joint.name], largest, links)

    def off_path(self, error: float, world: World) -> str:
        """Return that the joint is ``error`` [rad] off its path, and what touches."""
        return (
            f"joint '{self.name}' is {error:.3f} rad off its path, more than "
            f"{self.error:.3f} rad ({self.touching(world)})"
        )

    def not_arrived(self, error: float, world: World) -> str:
        """Return that the joint has not reached the end of its path, and why."""
        return (
            f"joint '{self.name}' is {error:.3f} rad from the end of its path "
            f"({self.touching(world)})"
        )

    def touching(self, world: World) -> str:
        """Return what the links beyond the joint touch."""
        found = external_contacts(self.links, world.contacts())
        return contacts_text(found) or "no contact: the load, or its stop"


@final
class ArmSupervision:
    """Finds motions that fail.  Only the thread of the tick may use it."""

    def __init__(
        self,
        model: RobotModel,
        hardware: RobotHardware,
        motions: ArmMotions,
        world: World,
    ) -> None:
        self._motions = motions
        self._arms = {
            name: _Arm(arm, model, hardware, world)
            for name, arm in find_arms(model).items()
        }

    def look(self, state: JointState, command: list[float]) -> list[tuple[str, str]]:
        """Return the arms whose motion has failed, with the reasons.

        ``command`` is the last one of each joint.  It takes 2 µs for an arm that is
        moved, unless something is wrong.
        """
        found = []
        for arm, controller in self._motions.supervised():
            reason = self._arms[arm].look(controller, state, command)
            if reason:
                found.append((arm, reason))
        return found


@final
class _Arm:
    def __init__(
        self,
        arm: ArmParts,
        model: RobotModel,
        hardware: RobotHardware,
        world: World,
    ) -> None:
        self._world = world
        limits = hardware.limits
        self._joints = [
            TrackedJoint.of(
                joint, limits.get(joint.name, joint.limits), model, hardware
            )
            for joint in arm.joints
        ]
        self._select = joint_selector([joint.number for joint in self._joints])
        self._suspicious = SUSPICIOUS * min(joint.error for joint in self._joints)

    def look(
        self,
        controller: ArmMotionController,
        state: JointState,
        command: list[float],
    ) -> str:
        """Return why the motion has failed; empty if it has not."""
        if controller.gives_way:
            return ""
        errors = map(sub, self._select(command), self._select(state.position))
        largest = max(map(abs, errors))
        if not largest <= self._suspicious:
            self._world.contacts()
            for joint, error in self._errors(state, command):
                if not error <= joint.error:
                    return joint.off_path(error, self._world)
        if controller.is_overdue(largest, state.time):
            for joint, error in self._errors(state, command):
                if error == largest:
                    return joint.not_arrived(error, self._world)
        return ""

    def _errors(
        self, state: JointState, command: list[float]
    ) -> Iterator[tuple[TrackedJoint, float]]:
        for joint in self._joints:
            k = joint.number
            yield joint, abs(command[k] - state.position[k])
