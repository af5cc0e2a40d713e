"""Handle for a gripper."""

from __future__ import annotations

from typing import final

from tool0.api.controller import GoalHandle, checked_timeout
from tool0.description.grasp_frames import flange_of, grasp_frame
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.transform import Transform
from tool0.errors import GoalTimeoutError
from tool0.protocol.channel import Channel
from tool0.protocol.gripper import GraspState, Grip, ReadGripper
from tool0.protocol.request import checked_value


@final
class Gripper:
    """A parallel gripper, which is moved by the controller that claims its joint."""

    def __init__(
        self, name: str, geometry: ParallelGripper, model: RobotModel, channel: Channel
    ) -> None:
        self._name = name
        self._geometry = geometry
        self._model = model
        self._channel = channel

    @property
    def geometry(self) -> ParallelGripper:
        """Geometry of the gripper, with the ranges of speed and force."""
        return self._geometry

    @property
    def name(self) -> str:
        """Name of the gripper: its prefix in the URDF or, by default, ``gripper``."""
        return self._name

    @property
    def opening(self) -> float:
        """Distance between the pads [m]; the gripper is closed at 0."""
        snapshot = self._channel.snapshot
        index = snapshot.joint_names.index(self.geometry.joint)
        return max(0.0, self.geometry.opening(snapshot.position[index]))

    def tcp(
        self, opening: float | None = None, relative_to: str | None = None
    ) -> Transform:
        """Return the pose of the point midway between the pads at an opening.

        The y axis points from pad to pad.  The z axis points away from the gripper.
        Pads that move on circles also move forward along z as the gripper closes: by 14
        mm on a 2F-85.

        Args:
            opening: Distance between the pads [m]; the default is the measured
                distance.
            relative_to: Link in whose frame the pose is given; the default is
                ``tool0``.

        Raises:
            ModelError: If the opening is out of range, or if the link does not exist.
            ControlError: If the gripper does not have two pads.
        """
        checked_value("tcp", "opening", opening, float | None)
        checked_value("tcp", "relative_to", relative_to, str | None)
        if opening is None:
            opening = min(self.opening, self.geometry.max_opening)
        if relative_to is None:
            relative_to = flange_of(self._model, self.geometry)
        return grasp_frame(self._model, self.geometry, opening, relative_to)

    @property
    def state(self) -> GraspState:
        """State of the gripper: its motion, the opening, and the width of an object.

        The state is computed from the last 0.1 s.
        """
        return self._channel.call(ReadGripper(gripper=self.name))

    def wait(self, timeout: float | None = None) -> GraspState:
        """Wait until the gripper stops moving, and return its state.

        A change in the force alone is not a motion; in this case, the call returns
        immediately.  For ``timeout``, see ``GoalHandle.wait``.

        Raises:
            GoalTimeoutError: If the gripper is still moving after ``timeout``.
        """
        state = self.state

        def stands_still() -> bool:
            nonlocal state
            state = self.state
            return state.motion != "moving"

        if not self._channel.wait_until(stands_still, checked_timeout(timeout)):
            raise GoalTimeoutError(f"the gripper still moves after {timeout} s")
        return state

    def move(
        self,
        *,
        opening: float | None = None,
        position: float | None = None,
        speed: float | None = None,
        force: float | None = None,
        effort: float | None = None,
    ) -> GoalHandle:
        """Move the pads to ``opening`` and return the goal.

        As on the real gripper, the speed and the force are settings of the drive, which
        apply until another goal moves the joint.

        Args:
            opening: Distance between the pads [m], 0 … ``geometry.max_opening``.
            position: Position of the driven joint [rad | m], instead of an opening.
            speed: Speed of the pads relative to each other [m/s], within
                ``geometry.speed``; the default is the maximum.
            force: Maximum force at each pad [N], within ``geometry.force``; the default
                is the gripper's maximum.  An object between the pads is gripped with
                this force.
            effort: Maximum effort of the driven joint [N·m | N], instead of a force; it
                corresponds to ``max_effort`` of ROS's GripperCommand.

        Raises:
            ModelError: If the opening is out of range.
            ControlError: If the speed, the force or the effort is out of range, or if
                no running controller accepts the command; the gripper's settings are
                then unchanged.
        """
        request = Grip(
            gripper=self.name,
            opening=opening,
            position=position,
            speed=speed,
            force=force,
            effort=effort,
        )
        return GoalHandle(self._channel.call(request), self._channel)
