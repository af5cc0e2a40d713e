"""The handle on a parallel gripper."""

from __future__ import annotations

from typing import final

from tool0.api.channel import Channel
from tool0.api.controller import GoalHandle
from tool0.description.model import ParallelGripper
from tool0.errors import GoalTimeoutError
from tool0.requests.gripper import Grip, ReadGripper
from tool0.sensing.grasp import GraspState


@final
class Gripper:
    """Moves one parallel gripper through the controller that claims its joint."""

    def __init__(self, geometry: ParallelGripper, channel: Channel) -> None:
        self.geometry = geometry
        self._channel = channel

    @property
    def name(self) -> str:
        return self.geometry.name

    @property
    def opening(self) -> float:
        """Distance between the pads [m], 0 closed."""
        snapshot = self._channel.snapshot
        index = snapshot.joint_names.index(self.geometry.joint)
        return max(0.0, self.geometry.opening(snapshot.position[index]))

    @property
    def state(self) -> GraspState:
        """Whether it moves, has arrived or holds something, and how wide that is.

        Computed from the last tenth of a second.
        """
        return self._channel.call(ReadGripper(gripper=self.name))

    def wait(self, timeout: float | None = None) -> GraspState:
        """Wait until it no longer moves, and return its state then.

        A change of force alone is no motion: it takes no time here.

        Args:
            timeout: Longest wait [s]: of wall time if the simulation runs in real
                time or in another process, otherwise of simulated time, which passes
                meanwhile.

        Raises:
            GoalTimeoutError: If it still moves then.
        """
        state = self.state

        def stands_still() -> bool:
            nonlocal state
            state = self.state
            return state.motion != "moving"

        if not self._channel.wait_until(stands_still, timeout):
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
            position: Instead of an opening: position of the driven joint [rad].
            speed: Of the pads relative to each other [m/s], within
                ``geometry.speed``; the fastest, if left out.
            force: Largest force at each pad [N], within ``geometry.force``: an object
                in between is gripped with it.  The strongest, if left out.
            effort: Instead of a force: largest torque of the driven joint [N·m], as
                ``max_effort`` of ROS's GripperCommand.

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
