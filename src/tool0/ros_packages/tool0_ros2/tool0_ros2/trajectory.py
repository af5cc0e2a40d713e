"""The topics, the action and the service of a JointTrajectoryController."""

from array import array
from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

from control_msgs import action, msg, srv
from rclpy.qos import DurabilityPolicy, QoSProfile
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from tool0_ros2 import requests
from tool0_ros2.actions import ActiveGoal, SimulatedAction
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.clock import to_seconds
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.messages import fill, to_duration, to_points, to_tolerances
from tool0_ros2.requests import ControllerMotion, GoalStarted, Outcome, Request

_OUTPUT_FIELDS = {"position": "positions", "velocity": "velocities", "effort": "effort"}
"""Name of the output field for each command interface."""


class FollowTrajectoryPart:
    """The action ``follow_joint_trajectory``, without topics or services."""

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        names, parameters = context.names, context.parameters
        claimed = (name for _, joints in context.status["claimed"] for name in joints)
        self._full = list(parameters.get("joints") or dict.fromkeys(claimed))
        self._joints = list(map(names.to_ros, self._full))
        self._outputs = [
            _OUTPUT_FIELDS[kind]
            for kind in parameters.get("command_interfaces", ["position"])
            if kind in _OUTPUT_FIELDS
        ]
        self._has_rate_errors = self._outputs[:1] != ["positions"]
        """Whether velocity errors are computed.  ROS does not compute velocity errors
        for position commands."""
        self._action = SimulatedAction(
            context,
            action.FollowJointTrajectory,
            "~/follow_joint_trajectory",
            start=self._start,
            result=_result,
            monitor_rate=parameters.get("action_monitor_rate", 20.0),
        )

    def wants(self) -> Sequence[str]:
        return (self._context.name,) if self._action.active else ()

    def publish(self, update: Update) -> None:
        motion = update.motions.get(self._context.name)
        if motion is not None:
            self._action.publish(
                update.time, lambda goal: self._feedback(goal, update, motion)
            )

    def close(self) -> None:
        self._action.close()

    def _feedback(
        self, goal: ActiveGoal, update: Update, motion: ControllerMotion
    ) -> Any:
        message = action.FollowJointTrajectory.Feedback()
        message.header.stamp = update.stamp
        trajectory = goal.request.trajectory
        start = self._context.clock.from_ros(trajectory.header.stamp)
        elapsed = update.time - (goal.accepted_at if start is None else start)
        times = [to_seconds(point.time_from_start) for point in trajectory.points]
        return fill(
            message,
            joint_names=self._joints,
            desired=_point(motion["reference"], motion["time_from_start"]),
            actual=_point(motion["feedback"]),
            error=self._error(motion),
            index=min(bisect_right(times, elapsed), len(times) - 1),
        )

    def _error(self, motion: ControllerMotion) -> JointTrajectoryPoint:
        positions, rates = motion["error"]
        return _point(
            [positions, rates if self._has_rate_errors else [0.0] * len(rates)]
        )

    def _start(self, goal: Any) -> Request[GoalStarted]:
        return requests.follow_trajectory(
            controller=self._context.name,
            **self._trajectory(goal.trajectory),
            path_tolerance=self._tolerances(goal.path_tolerance),
            goal_tolerance=self._tolerances(goal.goal_tolerance),
            goal_time_tolerance=to_seconds(goal.goal_time_tolerance),
        )

    def _tolerances(self, given: Any) -> dict[str, list[float]]:
        full = self._context.names.to_model
        return {full(joint): item for joint, item in to_tolerances(given).items()}

    def _trajectory(self, message: Any) -> dict[str, Any]:
        return {
            "points": to_points(message.points),
            "joint_names": list(map(self._context.names.to_model, message.joint_names)),
            "stamp": self._context.clock.from_ros(message.header.stamp),
        }


class JointTrajectoryPart(FollowTrajectoryPart):
    """Topics, action and ``query_state`` service of a JointTrajectoryController."""

    def __init__(self, context: ControllerContext) -> None:
        super().__init__(context)
        node = context.node
        self._picked: list[int] | None = None
        qos = QoSProfile(depth=10)
        self._publisher = node.create_publisher(
            msg.JointTrajectoryControllerState, "~/controller_state", qos
        )
        self._subscriptions = [
            node.create_subscription(
                JointTrajectory, "~/joint_trajectory", self._command, qos
            )
        ]
        if hasattr(msg, "SpeedScalingFactor"):
            latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            self._subscriptions.append(
                node.create_subscription(
                    msg.SpeedScalingFactor,
                    "~/speed_scaling_input",
                    self._scale,
                    latched,
                )
            )
        self._service = node.create_service(
            srv.QueryTrajectoryState, "~/query_state", self._query
        )

    def wants(self) -> Sequence[str]:
        is_watched = self._publisher.get_subscription_count()
        return (self._context.name,) if is_watched else super().wants()

    def publish(self, update: Update) -> None:
        motion = update.motions.get(self._context.name)
        if motion is not None and self._publisher.get_subscription_count():
            self._publisher.publish(self._state(update, motion))
        super().publish(update)

    def close(self) -> None:
        super().close()
        node = self._context.node
        node.destroy_publisher(self._publisher)
        node.destroy_service(self._service)
        for subscription in self._subscriptions:
            node.destroy_subscription(subscription)

    # ---- out ------------------------------------------------------------------------

    def _state(self, update: Update, motion: ControllerMotion) -> Any:
        message = msg.JointTrajectoryControllerState()
        message.header.stamp = update.stamp
        reference = _point(motion["reference"], motion["time_from_start"])
        feedback = _point(motion["feedback"])
        return fill(
            message,
            joint_names=self._joints,
            reference=reference,
            feedback=feedback,
            error=self._error(motion),
            output=self._output(update),
            speed_scaling_factor=motion["speed_scaling"],
            desired=reference,  # Humble also has these field names
            actual=feedback,
        )

    def _output(self, update: Update) -> JointTrajectoryPoint:
        picked = self._picked
        if picked is None:
            picked = self._picked = [update.index[joint] for joint in self._full]
        values = array("d", [update.command[k] for k in picked])
        return JointTrajectoryPoint(**dict.fromkeys(self._outputs[:1], values))

    # ---- in -------------------------------------------------------------------------

    def _command(self, message: Any) -> None:
        context = self._context
        if not message.points:  # to tool0, this is a stop
            context.report.error("joint_trajectory: Empty trajectory received.")
            return
        try:
            # The request is answered, so that the log contains the reason for a
            # refusal.
            future = context.connection.submit(
                requests.command_trajectory(
                    controller=context.name, **self._trajectory(message)
                )
            )
        except RequestFailedError as error:
            context.report.error(f"joint_trajectory: {error}")
            return
        future.add_done_callback(self._log_refusal)

    def _log_refusal(self, future: Any) -> None:
        error = future.exception()
        if error is not None:
            text = self._context.names.text(error)
            self._context.report.error(f"joint_trajectory: {text}")

    def _scale(self, message: Any) -> None:
        context = self._context
        future = context.connection.submit(
            requests.scale_trajectory(controller=context.name, factor=message.factor)
        )
        future.add_done_callback(self._log_refusal)

    def _query(self, request: Any, response: Any) -> Any:
        context = self._context
        try:
            motion = context.connection.call(
                requests.query_state(
                    controller=context.name, time=context.clock.from_ros(request.time)
                )
            )
        except RequestFailedError as error:
            text = context.names.text(error)
            context.report.error(f"query_state: {text}")
            return fill(response, success=False, message=text)
        return fill(
            response,
            success=True,
            name=self._joints,
            position=motion["positions"],
            velocity=motion["velocities"],
            acceleration=motion["accelerations"],
        )


def _point(motion: list[list[float]], time: float = 0.0) -> JointTrajectoryPoint:
    """Return positions, velocities and optional accelerations as a message."""
    positions, velocities, *rest = motion
    message = JointTrajectoryPoint()
    message.positions = array("d", positions)
    message.velocities = array("d", velocities)
    if rest:
        message.accelerations = array("d", rest[0])
    if time:
        message.time_from_start = to_duration(time)
    return message


def _result(outcome: Outcome) -> Any:
    result = action.FollowJointTrajectory.Result()
    result.error_code = outcome.get("error_code", 0)
    result.error_string = outcome.get("error_string", "")
    return result
