"""Commanded motions for drives with their own motion control."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import final

from tool0.control.manager import ControllerManager
from tool0.control.trajectory import Setpoint
from tool0.description.model import RobotModel
from tool0.description.parts import find_grippers
from tool0.hardware.engine import JointState
from tool0.hardware.own_drives import Wanted, WantedGrip, WantedMotion
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.state import ArmSetpoint
from tool0.simulation.arms.arms import Arms


@final
class WantedMotions:
    """Reads the motions that controllers follow.

    Only the thread that executes the tick may use ``WantedMotions``.
    """

    def __init__(
        self,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
        arms: Arms,
    ) -> None:
        self._hardware, self._manager = hardware, manager
        self._arm = next(iter(arms), None)
        self._grippers = {
            item.name: item.joint for item in find_grippers(model).values()
        }

    def look(self, state: JointState) -> Wanted:
        """Return the commands for a tick that starts with ``state``."""
        setpoints = self._manager.setpoints()
        grips = {
            name: WantedGrip(target, self._hardware.drive_limits.get(joint))
            for name, joint in self._grippers.items()
            if (target := _target(setpoints, joint)) is not None
        }
        is_stopped = self._hardware.is_stopped
        arm = None if is_stopped else self._motion(setpoints, state.time)
        return Wanted(state, arm, {} if is_stopped else grips)

    def _motion(
        self, setpoints: Mapping[str, Setpoint], now: float
    ) -> WantedMotion | None:
        if self._arm is None:
            return None
        motion = self._arm.motion
        joints = motion.spec.joints
        if motion.is_taken:
            streamed = motion.controller.unknown_setpoint(now)
            if streamed is not None:
                return WantedMotion(lambda time: streamed, is_streamed=True)
        for setpoint in setpoints.values():
            names = setpoint.joint_names
            if set(joints).issubset(names):
                order = [names.index(joint) for joint in joints]
                splines = tuple(setpoint.splines[k] for k in order)
                target = tuple(spline.target for spline in splines)
                key = (*splines, *target)  # the splines, since an id may be reused
                return WantedMotion(_along(setpoint, joints), target=target, key=key)
        return None


def _along(setpoint: Setpoint, joints: Sequence[str]) -> Callable[[float], ArmSetpoint]:
    """Return a function that returns the desired joint motion at a given time."""

    def at(time: float) -> ArmSetpoint:
        motion = setpoint.desired_motion(joints, time)
        assert motion is not None  # it has these joints
        return motion

    return at


def _target(setpoints: Mapping[str, Setpoint], joint: str) -> float | None:
    """Return the final position that a controller commands for a joint, or None."""
    for setpoint in setpoints.values():
        found = setpoint.desired_and_target(joint)
        if found is not None:
            return found[1]
    return None
