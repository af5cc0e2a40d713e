"""A rospy client for tests: subscribe, publish, call, send goals."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from ros import TIMEOUT
from ur5_rig import ARM, ARM_JOINTS
from waits import until

Message = Any
"""Of a class that ROS generates, which carries no types."""


class Topic:
    """A subscription that keeps every message."""

    def __init__(self, name: str, kind: type) -> None:
        from rospy import Subscriber

        self.name = name
        self.messages: list[Message] = []
        self._subscriber = Subscriber(
            name, kind, self.messages.append, queue_size=None, tcp_nodelay=True
        )

    def wait_for(
        self,
        condition: Callable[[Message], bool] = lambda message: True,
        *,
        since: int = 0,
        timeout: float = TIMEOUT,
    ) -> Message:
        """Return the first message, from number ``since``, that meets ``condition``."""

        def found() -> Message | None:
            return next((m for m in self.messages[since:] if condition(m)), None)

        return until(found, f"a message on {self.name}", timeout)

    def next(self, n: int = 1) -> list[Message]:
        """Return the next ``n`` messages."""
        since = len(self.messages)
        until(lambda: len(self.messages) >= since + n, f"{n} messages on {self.name}")
        return self.messages[since : since + n]

    def close(self) -> None:
        self._subscriber.unregister()


@contextlib.contextmanager
def listening(name: str, kind: type) -> Iterator[Topic]:
    """Subscribe; enter at the first message."""
    topic = Topic(name, kind)
    try:
        topic.wait_for()
        yield topic
    finally:
        topic.close()


@contextlib.contextmanager
def publishing(name: str, kind: type) -> Iterator[Callable[[Message], None]]:
    """Return a function that publishes, once there is a subscriber."""
    from rospy import Publisher

    publisher = Publisher(name, kind, queue_size=10)
    try:
        until(publisher.get_num_connections, f"a subscriber of {name}")
        yield publisher.publish
    finally:
        publisher.unregister()


def call(name: str, kind: type, *arguments: object, **named: object) -> Message:
    """Call a service once."""
    from rospy import ServiceProxy

    return ServiceProxy(name, kind)(*arguments, **named)


def at(stamp: Message) -> float:
    """Return a time of ROS [s]."""
    seconds: float = stamp.to_sec()
    return seconds


def state(topic: Topic) -> Mapping[str, float]:
    """Return joint → position, of the next message on a topic of joint states."""
    (message,) = topic.next()
    return dict(zip(message.name, message.position, strict=True))


def trajectory(
    points: Sequence[tuple[float, Sequence[float]]],
    joints: Sequence[str] = ARM_JOINTS,
    *,
    stamp: Message = None,
    at_rest: bool = True,
) -> Message:
    """Return a trajectory_msgs/JointTrajectory.

    Args:
        points: When [s] and where [rad].
        joints: Whose.
        stamp: When it starts; at once, if left out.
        at_rest: Whether the points have velocities, of 0.
    """
    from rospy import Duration
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    message = JointTrajectory(joint_names=joints)
    message.header.stamp = stamp or message.header.stamp
    message.points = [
        JointTrajectoryPoint(
            positions=positions,
            velocities=[0.0] * len(positions) if at_rest else [],
            time_from_start=Duration.from_sec(time),
        )
        for time, positions in points
    ]
    return message


def follow_goal(message: Message, **options: object) -> Message:
    """Return a control_msgs/FollowJointTrajectoryGoal."""
    from control_msgs.msg import FollowJointTrajectoryGoal

    return FollowJointTrajectoryGoal(trajectory=message, **options)


def arm_client(controller: str = ARM) -> Message:
    """Return a connected actionlib client of a trajectory controller."""
    from actionlib import SimpleActionClient
    from control_msgs.msg import FollowJointTrajectoryAction

    return connected(
        SimpleActionClient(
            f"{controller}/follow_joint_trajectory", FollowJointTrajectoryAction
        )
    )


def connected(client: Message) -> Message:
    """Return ``client`` once it is connected."""
    from rospy import Duration

    assert client.wait_for_server(Duration(10)), "no action server"
    return client


def outcome(client: Message, timeout: float = TIMEOUT) -> tuple[int, Message]:
    """Wait for the goal of an actionlib client; return its status and result."""
    from actionlib_msgs.msg import GoalStatus

    terminal = (
        *(GoalStatus.SUCCEEDED, GoalStatus.ABORTED, GoalStatus.REJECTED),
        *(GoalStatus.PREEMPTED, GoalStatus.RECALLED, GoalStatus.LOST),
    )
    until(lambda: client.get_state() in terminal, "the end of a goal", timeout)
    # The result may come after the status.
    until(client.get_result, "the result of a goal", timeout)
    return client.get_state(), client.get_result()
