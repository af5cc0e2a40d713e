"""Whether the arms that programs move follow their setpoints, and arrive.

It is looked at every 8 ms of simulated time, for every mode of ``ArmMotionController``
but those that give way (force mode, freedrive): nothing is computed in the tick, and
nothing depends on who reads.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from operator import sub
from typing import Final, final

from tool0.control.arm.motion import ArmMotionController
from tool0.control.manager import ControllerManager
from tool0.description.model import RobotModel
from tool0.description.parts import find_arms
from tool0.hardware.engine import JointState, World, joint_selector
from tool0.hardware.robot_hardware import RobotHardware
from tool0.simulation.arm_motions import ArmMotions
from tool0.simulation.path_errors import PathErrors, TrackedJoint

SUSPICIOUS: Final = 0.5
"""Part of the largest lag from which contacts are read: an engine may record them only
after the first call."""


@final
class ArmSupervision:
    """Finds motions that fail.  Only the thread of the tick may use it."""

    def __init__(
        self,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
        motions: ArmMotions,
        world: World,
    ) -> None:
        self._motions = motions
        self._arms = {
            name: _Arm(PathErrors(arm, model, hardware, manager, world))
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
    def __init__(self, path_errors: PathErrors) -> None:
        self._path_errors = path_errors
        self._joints = path_errors.joints
        self._select = joint_selector([joint.number for joint in self._joints])
        self._suspicious = SUSPICIOUS * min(
            (j.error for j in self._joints), default=math.inf
        )

    def look(
        self,
        controller: ArmMotionController,
        state: JointState,
        command: list[float],
    ) -> str:
        """Return why the motion has failed; empty if it has not."""
        if controller.is_compliant:
            return ""
        errors = map(sub, self._select(command), self._select(state.position))
        largest = max(map(abs, errors))
        if not largest <= self._suspicious:
            self._path_errors.watch(state.time)
            for joint, error in self._errors(state, command):
                if not error <= joint.error:
                    return self._path_errors.off_path(joint, error, state)
        if controller.is_overdue(largest, state.time):
            for joint, error in self._errors(state, command):
                if error == largest:
                    return self._path_errors.not_arrived(joint, error, state)
        return ""

    def _errors(
        self, state: JointState, command: list[float]
    ) -> Iterator[tuple[TrackedJoint, float]]:
        for joint in self._joints:
            k = joint.number
            yield joint, abs(command[k] - state.position[k])
