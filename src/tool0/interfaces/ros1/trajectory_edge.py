"""A JointTrajectoryController in ROS: command, state, the action, query_state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

from tool0.api.controller import ControllerHandle
from tool0.control.goal import GoalResult, Result
from tool0.control.joint_trajectory import JointTrajectorySpec
from tool0.control.publish_rate import PublishRate
from tool0.errors import ControlError, GoalRejectedError, Tool0Error
from tool0.interfaces.ros1.actions import ActionEdge
from tool0.interfaces.ros1.conversions import Message, Trajectories
from tool0.interfaces.ros1.node import RosNode
from tool0.sensing.snapshot import Snapshot


@final
class TrajectoryEdge:
    """Topics, action and service of one controller, running or not."""

    def __init__(
        self, node: RosNode, spec: JointTrajectorySpec, controller: ControllerHandle
    ) -> None:
        from control_msgs.msg import (
            FollowJointTrajectoryAction,
            FollowJointTrajectoryFeedback,
            FollowJointTrajectoryResult,
            JointTrajectoryControllerState,
        )
        from control_msgs.srv import (
            QueryTrajectoryState,
            QueryTrajectoryStateResponse,
        )
        from trajectory_msgs.msg import JointTrajectory

        self._node = node
        self._name = spec.name
        self._joints = spec.joints
        self._controller = controller
        self._convert = Trajectories(node.time)
        self._rate = PublishRate(spec.state_publish_rate)
        self._state = JointTrajectoryControllerState
        self._feedback = FollowJointTrajectoryFeedback
        self._result = FollowJointTrajectoryResult
        self._answer = QueryTrajectoryStateResponse
        self._publisher = node.publisher(
            f"{self._name}/state", JointTrajectoryControllerState, queue_size=10
        )
        self._action = ActionEdge(
            node,
            f"{self._name}/follow_joint_trajectory",
            FollowJointTrajectoryAction,
            start=self._start,
            refusal=self._refusal,
            outcome=self._outcome,
            monitor_rate=spec.action_monitor_rate,
        )
        self._others = (
            node.subscriber(f"{self._name}/command", JointTrajectory, self._command),
            node.service(
                f"{self._name}/query_state", QueryTrajectoryState, self._query
            ),
        )

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the state, if the controller runs and it is time to."""
        setpoint = snapshot.controller_setpoints.get(self._name)
        if setpoint is None:
            return

        def fill(kind: Callable[[], Message]) -> Message:
            return self._convert.fill(kind(), setpoint.state())

        if self._rate.is_due(snapshot.time):
            self._publisher.publish(fill(self._state))
        self._action.publish(snapshot.time, lambda: fill(self._feedback))

    def restart(self) -> None:
        """Forget times: simulated time has gone back to zero."""
        self._action.restart()

    def close(self) -> None:
        """Present it no longer."""
        self._action.close()
        self._publisher.unregister()
        command, query = self._others
        command.unregister()
        query.shutdown(f"controller '{self._name}' was unloaded")

    def _command(self, trajectory: Message) -> None:
        goal = self._convert.goal(trajectory)
        self._controller.command_trajectory(
            goal.points, joint_names=goal.joint_names, stamp=goal.stamp
        )

    def _start(self, message: Message) -> Any:
        goal = self._convert.action_goal(message)
        return self._controller.follow(
            goal.points,
            joint_names=goal.joint_names,
            stamp=goal.stamp,
            path_tolerance=goal.path_tolerance,
            goal_tolerance=goal.goal_tolerance,
            goal_time_tolerance=goal.goal_time_tolerance,
        )

    def _refusal(self, error: Tool0Error) -> Message:
        code = error.code if isinstance(error, GoalRejectedError) else None
        return self._result(
            error_code=GoalRejectedError.INVALID_GOAL if code is None else code,
            error_string=str(error),
        )

    def _outcome(self, result: Result) -> Message:
        assert isinstance(result, GoalResult)
        return self._result(
            error_code=result.error_code, error_string=result.error_string
        )

    def _query(self, request: Message) -> Message:
        time = self._node.time.from_ros(request.time)
        if time is None:
            raise ControlError("query_state needs a time above 0 s")
        point = self._controller.query_state(time)
        return self._answer(
            name=self._joints,
            position=point.positions,
            velocity=point.velocities or (),
            acceleration=point.accelerations or (),
        )
