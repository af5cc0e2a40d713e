"""An action of ROS over a controller's goals."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, final

from tool0.api.controller import GoalHandle
from tool0.control.goal import GoalStatus, Result
from tool0.control.publish_rate import PublishRate
from tool0.errors import Tool0Error
from tool0.interfaces.ros1.node import RosNode

Message = Any
"""Of a class that ROS generates, which carries no types."""

STATUS_RATE = 5.0
"""[Hz] of simulated time, as actionlib's own timer has it, which dies of a reset."""


@final
class ActionEdge:
    """Takes goals for one controller, tells how they go, and how they end."""

    def __init__(
        self,
        node: RosNode,
        name: str,
        kind: Any,
        *,
        start: Callable[[Message], GoalHandle],
        refusal: Callable[[Tool0Error], Message],
        outcome: Callable[[Result], Message],
        monitor_rate: float,
    ) -> None:
        """Listen for goals.

        Args:
            node: The node.
            name: The action's, in the node's namespace.
            kind: The action's class, such as FollowJointTrajectoryAction.
            start: Gives a goal to the controller, or raises Tool0Error.
            refusal: Makes the result of a goal that was refused.
            outcome: Makes the result of one that ended.
            monitor_rate: How often feedback is due [Hz].
        """
        from actionlib import ActionServer
        from rospy import Time

        self._node = node
        self._start, self._refusal, self._outcome = start, refusal, outcome
        self._rate = PublishRate(monitor_rate)
        self._status_rate = PublishRate(STATUS_RATE)
        self._active: dict[Message, GoalHandle] = {}
        self._zero = Time()
        self._server = ActionServer(
            node.name(name), kind, self._accept, self._cancel, auto_start=False
        )
        self._server.start()
        if self._server.status_timer is not None:
            self._server.status_timer.shutdown()

    def publish(self, time: float, feedback: Callable[[], Message]) -> None:
        """Tell how goals are and how they go, if it is time to [s]."""
        if self._status_rate.is_due(time):
            self._server.publish_status()
        if self._rate.is_due(time) and self._active:
            message = feedback()
            for goal in tuple(self._active):
                goal.publish_feedback(message)

    def restart(self) -> None:
        """Forget when something was cancelled: it may lie in the future now."""
        self._server.last_cancel = self._zero

    def close(self) -> None:
        """Take no more goals."""
        self._server.stop()

    def _accept(self, goal: Message) -> None:
        try:
            handle = self._start(goal.get_goal())
        except Tool0Error as error:
            self._node.complain(f"{self._server.ns}: {error}")
            goal.set_rejected(self._refusal(error), str(error))
            return
        goal.set_accepted()
        self._active = {**self._active, goal: handle}
        handle.when_finished(
            lambda handle: self._node.defer(partial(self._finish, goal, handle))
        )

    def _cancel(self, goal: Message) -> None:
        handle = self._active.get(goal)
        if handle is not None:
            handle.cancel()

    def _finish(self, goal: Message, handle: GoalHandle) -> None:
        result = handle.result
        assert result is not None  # it is why we are called
        with self._server.lock:  # which whoever accepted it holds until it is active
            self._active = {
                other: h for other, h in self._active.items() if other != goal
            }
        message = self._outcome(result)
        text = getattr(result, "error_string", "")
        match result.status:
            case GoalStatus.SUCCEEDED:
                goal.set_succeeded(message, text)
            case GoalStatus.ABORTED:
                goal.set_aborted(message, text)
            case _:
                goal.set_canceled(message, text)
