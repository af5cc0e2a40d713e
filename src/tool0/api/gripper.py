"""The handle on a gripper."""

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
    """A parallel gripper, moved through the controller that claims its joint."""

    def __init__(
        self, name: str, geometry: ParallelGripper, model: RobotModel, channel: Channel
    ) -> None:
        self._name = name
        self._geometry = geometry
        self._model = model
        self._channel = channel

    @property
    def geometry(self) -> ParallelGripper:
        """Opening as a function of the joint's position; ranges of speed and force."""
        return self._geometry

    @property
    def name(self) -> str:
        """The prefix of its name in the URDF, ``gripper`` without one."""
        return self._name

    @property
    def opening(self) -> float:
        """Distance between the pads [m], 0 closed."""
        snapshot = self._channel.snapshot
        index = snapshot.joint_names.index(self.geometry.joint)
        return max(0.0, self.geometry.opening(snapshot.position[index]))

    def tcp(
        self, opening: float | None = None, relative_to: str | None = None
    ) -> Transform:
        """Return the pose of the point midway between the pads at an opening.

        y points from pad to pad, z away from the gripper.  Pads that move on circles
        advance along z while they close, by 14 mm on a 2F-85.

        Args:
            opening: Distance between the pads [m]; the measured one, if left out.
            relative_to: The link in whose frame the pose is; ``tool0``, if left out.

        Raises:
            ModelError: If the opening is out of reach, or there is no such link.
            ControlError: If the gripper has no two pads.
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
        """Whether it moves, has arrived or holds an object, and the object's width.

        Computed from the last tenth of a second.
        """
        return self._channel.call(ReadGripper(gripper=self.name))

    def wait(self, timeout: float | None = None) -> GraspState:
        """Wait until it stops moving, and return its state.

        A change of force alone is no motion: the call returns at once.  ``timeout`` is
        as for ``GoalHandle.wait``.

        Raises:
            GoalTimeoutError: If it still moves then.
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

        Speed and force are settings of the drive, as on the real gripper: they hold
        until another goal moves its joint.

        Args:
            opening: Distance between the pads [m], 0 … ``geometry.max_opening``.
            position: Instead of an opening: position of the driven joint
                [rad | m].
            speed: Speed of the pads relative to each other [m/s], within
                ``geometry.speed``; the fastest, if left out.
            force: Largest force at each pad [N], within ``geometry.force``: an object
                between them is gripped with it.  The maximum, if left out.
            effort: Instead of a force: largest effort of the driven joint [N·m | N],
                as ``max_effort`` of ROS's GripperCommand.

        Raises:
            ModelError: If the opening is out of reach.
            ControlError: If speed, force or effort are out of range, or no running
                controller takes the command; nothing has changed then.
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
