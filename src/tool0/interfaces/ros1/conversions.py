"""Trajectories as ROS's messages say them ↔ as the controllers take and tell them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

from tool0.control.goal import Tolerance
from tool0.control.trajectory import (
    JointsMotion,
    TrajectoryGoal,
    TrajectoryPoint,
    TrajectoryState,
)
from tool0.interfaces.ros1.ros_time import RosTime

Message = Any
"""Of a class that ROS generates, which carries no types."""


@final
class Trajectories:
    """Converts, in the time of one bring-up."""

    def __init__(self, time: RosTime) -> None:
        from rospy import Duration
        from trajectory_msgs.msg import (
            JointTrajectoryPoint,
        )

        self._time = time
        self._duration = Duration
        self._point = JointTrajectoryPoint

    def goal(self, trajectory: Message) -> TrajectoryGoal:
        """Return a trajectory_msgs/JointTrajectory as a goal without tolerances."""
        return TrajectoryGoal(
            points=_points(trajectory.points),
            # Without points it means: stop, whatever joints it names.
            joint_names=tuple(trajectory.joint_names) if trajectory.points else None,
            stamp=self._time.from_ros(trajectory.header.stamp),
        )

    def action_goal(self, goal: Message) -> TrajectoryGoal:
        """Return a control_msgs/FollowJointTrajectoryGoal."""
        return TrajectoryGoal(
            points=_points(goal.trajectory.points),
            joint_names=tuple(goal.trajectory.joint_names),
            stamp=self._time.from_ros(goal.trajectory.header.stamp),
            path_tolerance=_tolerances(goal.path_tolerance),
            goal_tolerance=_tolerances(goal.goal_tolerance),
            goal_time_tolerance=goal.goal_time_tolerance.to_sec(),
        )

    def fill(self, message: Message, state: TrajectoryState) -> Message:
        """Return ``message``, of the controller's state or of feedback, with ``state``.

        As in ROS, only what is desired has accelerations.
        """
        message.header.stamp = self._time.to_ros(state.time)
        message.joint_names = state.joint_names
        message.desired = self.point(state.desired)
        message.actual = self.point(state.actual)
        message.error = self.point(state.error)
        return message

    def point(self, motion: JointsMotion) -> Message:
        """Return a trajectory_msgs/JointTrajectoryPoint."""
        return self._point(
            positions=motion.positions,
            velocities=motion.velocities,
            accelerations=motion.accelerations,
            time_from_start=self._duration.from_sec(motion.time_from_start),
        )


def _points(points: Sequence[Message]) -> tuple[TrajectoryPoint, ...]:
    return tuple(
        TrajectoryPoint(
            positions=point.positions,
            velocities=point.velocities or None,
            accelerations=point.accelerations or None,
            time_from_start=point.time_from_start.to_sec(),
        )
        for point in points
    )


def _tolerances(tolerances: Sequence[Message]) -> dict[str, Tolerance]:
    return {
        item.name: Tolerance(item.position, item.velocity, item.acceleration)
        for item in tolerances
    }
