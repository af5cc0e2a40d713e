"""The ROS interface of each controller type: topics, actions and services."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, final

from actionlib import ActionServer
from control_msgs import msg, srv
from rospy import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

from tool0.api.controller import ControllerHandle, GoalHandle
from tool0.control.forward_command import ForwardCommandSpec
from tool0.control.gripper_action import GripperActionSpec
from tool0.control.publish_rate import PublishRate
from tool0.control.ros1.joint_state import JointStateSpec
from tool0.control.ros1.joint_trajectory import JointTrajectorySpec
from tool0.errors import ControlError, GoalRejectedError, Tool0Error
from tool0.protocol.goals import GoalStatus, GripperResult, Result, Tolerance
from tool0.protocol.state import Snapshot
from tool0.protocol.trajectories import TrajectoryState
from tool0.ros1.messages import Message, point_message, to_points, to_tolerances
from tool0.ros1.namespace import RosNamespace

STATUS_RATE = 5.0
"""Rate at which the status of goals is published [Hz].  The rate is the same as
actionlib's.  The status is published here in simulated time, because actionlib's timer
stops when time moves back."""


@final
class ControllerActionServer:
    """Accepts goals for one controller, and publishes feedback, status and results."""

    def __init__(
        self,
        ros: RosNamespace,
        name: str,
        kind: Any,
        *,
        start: Callable[[Message], GoalHandle],
        rejection: Callable[[Tool0Error], Message],
        result: Callable[[Any], Message],
        monitor_rate: float,
    ) -> None:
        """Start an action of class ``kind``, with feedback at ``monitor_rate`` [Hz].

        ``start`` sends a goal message to the controller, or raises Tool0Error.
        ``rejection`` returns the result message after a goal is rejected, and
        ``result`` returns the result message at the end of a goal.
        """
        self._ros = ros
        self._start, self._rejection, self._result = start, rejection, result
        self._rate = PublishRate(monitor_rate)
        self._status_rate = PublishRate(STATUS_RATE)
        self._time = 0.0
        self._active: dict[Message, GoalHandle] = {}
        self._server = ActionServer(
            ros.name(name), kind, self._accept, self._cancel, auto_start=False
        )
        self._server.start()
        if self._server.status_timer is not None:
            self._server.status_timer.shutdown()

    def publish(self, time: float, feedback: Callable[[], Message]) -> None:
        """Publish status and feedback if they are due at ``time`` [s]."""
        if time < self._time:
            # Because time has moved back, the time of the last cancellation may be in
            # the future.  With a cancellation in the future, actionlib would recall
            # every goal until that time.
            self._server.last_cancel = Time()
        self._time = time
        if self._status_rate.is_due(time):
            self._server.publish_status()
        if self._rate.is_due(time) and self._active:
            message = feedback()
            for goal in tuple(self._active):
                goal.publish_feedback(message)

    def close(self) -> None:
        self._server.stop()

    def _accept(self, goal: Message) -> None:
        try:
            handle = self._start(goal.get_goal())
        except Tool0Error as error:
            self._ros.log_error(self._server.ns, error)
            goal.set_rejected(self._rejection(error), self._ros.text(error))
            return
        goal.set_accepted()
        self._active = {**self._active, goal: handle}
        handle.when_finished(
            lambda handle: self._ros.node.submit(partial(self._finish, goal, handle))
        )

    def _cancel(self, goal: Message) -> None:
        handle = self._active.get(goal)
        if handle is not None:
            handle.cancel()

    def _finish(self, goal: Message, handle: GoalHandle) -> None:
        outcome: Result | None = handle.result
        assert outcome is not None  # the goal has ended
        with self._server.lock:  # _accept holds the lock until the goal is in _active
            self._active = {g: h for g, h in self._active.items() if g != goal}
        message = self._result(outcome)
        text = getattr(message, "error_string", "")
        match outcome.status:
            case GoalStatus.SUCCEEDED:
                goal.set_succeeded(message, text)
            case GoalStatus.ABORTED:
                goal.set_aborted(message, text)
            case _:
                goal.set_canceled(message, text)


@final
class JointTrajectoryBridge:
    """Topics, action and ``query_state`` service of a JointTrajectoryController."""

    def __init__(
        self, ros: RosNamespace, spec: JointTrajectorySpec, controller: ControllerHandle
    ) -> None:
        self._ros = ros
        self._name = spec.name
        self._joints = tuple(map(ros.to_ros, spec.joints))
        self._controller = controller
        self._rate = PublishRate(spec.state_publish_rate)
        name = ros.to_ros(spec.name)
        self._publisher = ros.publisher(
            f"{name}/state", msg.JointTrajectoryControllerState, queue_size=10
        )
        self._action = ControllerActionServer(
            ros,
            f"{name}/follow_joint_trajectory",
            msg.FollowJointTrajectoryAction,
            start=self._start,
            rejection=self._rejection,
            result=lambda outcome: msg.FollowJointTrajectoryResult(
                error_code=outcome.error_code,
                error_string=ros.text(outcome.error_string),
            ),
            monitor_rate=spec.action_monitor_rate,
        )
        self._subscriber = ros.subscriber(
            f"{name}/command", JointTrajectory, self._command
        )
        self._service = ros.service(
            f"{name}/query_state", srv.QueryTrajectoryState, self._query
        )

    def publish(self, snapshot: Snapshot) -> None:
        setpoint = snapshot.controller_setpoints.get(self._name)
        if setpoint is None:
            return
        if self._rate.is_due(snapshot.time) and self._publisher.get_num_connections():
            message = msg.JointTrajectoryControllerState()
            self._publisher.publish(self._filled(message, setpoint.state()))
        self._action.publish(
            snapshot.time,
            lambda: self._filled(msg.FollowJointTrajectoryFeedback(), setpoint.state()),
        )

    def close(self) -> None:
        self._action.close()
        self._publisher.unregister()
        self._subscriber.unregister()
        self._service.shutdown(
            f"controller '{self._ros.to_ros(self._name)}' was unloaded"
        )

    def _filled(self, message: Message, state: TrajectoryState) -> Message:
        """Fill a state or feedback message.

        As in ROS, only the desired motion has accelerations.
        """
        message.header.stamp = self._ros.node.clock.to_ros(state.time)
        message.joint_names = list(map(self._ros.to_ros, state.joint_names))
        message.desired = point_message(state.desired)
        message.actual = point_message(state.actual)
        message.error = point_message(state.error)
        return message

    def _command(self, trajectory: Message) -> None:
        self._controller.command_trajectory(
            to_points(trajectory.points),
            # A message without points stops the motion of all joints, even if it names
            # joints.
            joint_names=self._full(trajectory.joint_names)
            if trajectory.points
            else None,
            stamp=self._ros.node.clock.from_ros(trajectory.header.stamp),
        )

    def _start(self, goal: Message) -> GoalHandle:
        return self._controller.follow(
            to_points(goal.trajectory.points),
            joint_names=self._full(goal.trajectory.joint_names),
            stamp=self._ros.node.clock.from_ros(goal.trajectory.header.stamp),
            path_tolerance=self._tolerances(goal.path_tolerance),
            goal_tolerance=self._tolerances(goal.goal_tolerance),
            goal_time_tolerance=goal.goal_time_tolerance.to_sec(),
        )

    def _rejection(self, error: Tool0Error) -> Message:
        code = error.code if isinstance(error, GoalRejectedError) else None
        return msg.FollowJointTrajectoryResult(
            error_code=GoalRejectedError.INVALID_GOAL if code is None else code,
            error_string=self._ros.text(error),
        )

    def _full(self, joints: Sequence[str]) -> list[str]:
        return list(map(self._ros.to_model, joints))

    def _tolerances(self, tolerances: Sequence[Message]) -> dict[str, Tolerance]:
        found = to_tolerances(tolerances)
        return {self._ros.to_model(joint): item for joint, item in found.items()}

    def _query(self, request: Message) -> Message:
        time = self._ros.node.clock.from_ros(request.time)
        if time is None:
            raise ControlError("query_state needs a time above 0 s")
        point = self._controller.query_state(time)
        return srv.QueryTrajectoryStateResponse(
            name=self._joints,
            position=point.positions,
            velocity=point.velocities or (),
            acceleration=point.accelerations or (),
        )


@final
class JointStatePublisher:
    """Topic ``joint_states`` of a JointStateController."""

    def __init__(
        self, ros: RosNamespace, spec: JointStateSpec, controller: ControllerHandle
    ) -> None:
        del controller  # this controller takes no commands
        self._ros, self._spec = ros, spec
        self._rate = PublishRate(spec.publish_rate)
        self._publisher = ros.publisher("joint_states", JointState, queue_size=100)

    def publish(self, snapshot: Snapshot) -> None:
        is_due = self._rate.is_due(snapshot.time)
        if not (is_due and self._publisher.get_num_connections()):
            return
        joints = self._spec.message(
            snapshot.joint_names, snapshot.position, snapshot.velocity, snapshot.effort
        )
        self._publisher.publish(
            header=self._ros.header(snapshot.time),
            name=list(map(self._ros.to_ros, joints.names)),
            position=joints.position,
            velocity=joints.velocity,
            effort=joints.effort,
        )

    def close(self) -> None:
        self._publisher.unregister()


@final
class ForwardCommandBridge:
    """Topic ``command`` of a forwarding controller: Float64 or Float64MultiArray."""

    def __init__(
        self, ros: RosNamespace, spec: ForwardCommandSpec, controller: ControllerHandle
    ) -> None:
        self._subscriber = ros.subscriber(
            f"{ros.to_ros(spec.name)}/command",
            Float64MultiArray if "JointGroup" in spec.type else Float64,
            lambda message: controller.command(message.data),
        )

    def publish(self, snapshot: Snapshot) -> None:
        """Publish nothing, because forwarding controllers have no state topic."""

    def close(self) -> None:
        self._subscriber.unregister()


@final
class GripperActionBridge:
    """Action ``gripper_cmd`` of a GripperActionController."""

    def __init__(
        self, ros: RosNamespace, spec: GripperActionSpec, controller: ControllerHandle
    ) -> None:
        self._joint = spec.joint.name
        self._position = 0.0
        self._action = ControllerActionServer(
            ros,
            f"{ros.to_ros(spec.name)}/gripper_cmd",
            msg.GripperCommandAction,
            start=lambda goal: controller.command_gripper(
                goal.command.position, goal.command.max_effort
            ),
            # actionlib has a separate field for the text of the error
            rejection=lambda _: msg.GripperCommandResult(position=self._position),
            result=_gripper_result,
            monitor_rate=spec.action_monitor_rate,
        )

    def publish(self, snapshot: Snapshot) -> None:
        index = snapshot.joint_names.index(self._joint)
        self._position = position = snapshot.position[index]
        effort = snapshot.effort[index]
        self._action.publish(
            snapshot.time,
            lambda: msg.GripperCommandFeedback(position=position, effort=effort),
        )

    def close(self) -> None:
        self._action.close()


def _gripper_result(outcome: GripperResult) -> Message:
    return msg.GripperCommandResult(
        position=outcome.position,
        effort=outcome.effort,
        stalled=outcome.stalled,
        reached_goal=outcome.reached_goal,
    )
