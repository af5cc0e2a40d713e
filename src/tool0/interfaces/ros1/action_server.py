"""An action of ROS over a controller's goals."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, final

from actionlib import ActionServer
from rospy import Time

from tool0.api.controller import GoalHandle
from tool0.control.goal import GoalStatus, Result
from tool0.control.joint_state import PublishRate
from tool0.errors import Tool0Error
from tool0.interfaces.ros1.messages import Message
from tool0.interfaces.ros1.node import RosNode

STATUS_RATE = 5.0
"""Of the goals' status [Hz], as actionlib's own.  It is published here, in simulated
time: actionlib's timer ends when time goes back."""


@final
class ControllerActionServer:
    """Accepts goals for one controller, and publishes feedback, status and result."""

    def __init__(
        self,
        node: RosNode,
        name: str,
        kind: Any,
        *,
        start: Callable[[Message], GoalHandle],
        rejection: Callable[[Tool0Error], Message],
        result: Callable[[Any], Message],
        monitor_rate: float,
    ) -> None:
        """Start the action server.

        Args:
            node: The node.
            name: The action's name in the node's namespace.
            kind: The action's class, such as FollowJointTrajectoryAction.
            start: Sends a goal message to the controller, or raises Tool0Error.
            rejection: Returns the result message of a goal that was rejected.
            result: Returns the result message of a goal's outcome.
            monitor_rate: Rate of the feedback [Hz].
        """
        self._node = node
        self._start, self._rejection, self._result = start, rejection, result
        self._rate = PublishRate(monitor_rate)
        self._status_rate = PublishRate(STATUS_RATE)
        self._time = 0.0
        self._active: dict[Message, GoalHandle] = {}
        self._server = ActionServer(
            node.name(name), kind, self._accept, self._cancel, auto_start=False
        )
        self._server.start()
        if self._server.status_timer is not None:
            self._server.status_timer.shutdown()

    def publish(self, time: float, feedback: Callable[[], Message]) -> None:
        """Publish status and feedback, if they are due at ``time`` [s]."""
        if time < self._time:
            # The last cancellation may lie in the future now: actionlib would recall
            # every goal until then.
            self._server.last_cancel = Time()
        self._time = time
        if self._status_rate.is_due(time):
            self._server.publish_status()
        if self._rate.is_due(time) and self._active:
            message = feedback()
            for goal in tuple(self._active):
                goal.publish_feedback(message)

    def close(self) -> None:
        """Accept no more goals."""
        self._server.stop()

    def _accept(self, goal: Message) -> None:
        try:
            handle = self._start(goal.get_goal())
        except Tool0Error as error:
            self._node.log_error(f"{self._server.ns}: {error}")
            goal.set_rejected(self._rejection(error), str(error))
            return
        goal.set_accepted()
        self._active = {**self._active, goal: handle}
        handle.when_finished(
            lambda handle: self._node.submit(partial(self._finish, goal, handle))
        )

    def _cancel(self, goal: Message) -> None:
        handle = self._active.get(goal)
        if handle is not None:
            handle.cancel()

    def _finish(self, goal: Message, handle: GoalHandle) -> None:
        outcome: Result | None = handle.result
        assert outcome is not None  # the goal has ended
        with self._server.lock:  # _accept holds it until the goal is in _active
            self._active = {g: h for g, h in self._active.items() if g != goal}
        message = self._result(outcome)
        text = getattr(outcome, "error_string", "")
        match outcome.status:
            case GoalStatus.SUCCEEDED:
                goal.set_succeeded(message, text)
            case GoalStatus.ABORTED:
                goal.set_aborted(message, text)
            case _:
                goal.set_canceled(message, text)
