"""Actions whose goals run in the simulation."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.qos import HistoryPolicy, QoSProfile

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext, Rate
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.requests import GoalStarted, Outcome, Request

_SUCCEEDED, _PREEMPTED = "SUCCEEDED", "PREEMPTED"
_EVERY_REQUEST = QoSProfile(history=HistoryPolicy.KEEP_ALL)
"""Quality of service of an action's services.  All requests are kept, because many
goals may be received while one goal is checked."""


@dataclass
class ActiveGoal:
    """A goal that the simulation executes."""

    number: int
    """Number that identifies the goal in requests."""
    handle: Any
    """The goal's rclpy.action.server.ServerGoalHandle."""
    accepted_at: float = float("nan")
    """Simulated time of the first update after the goal was accepted [s]."""

    @property
    def request(self) -> Any:
        """The goal's message."""
        return self.handle.request


class _DeferringServer(ActionServer):  # type: ignore[misc]  # rclpy has no types
    """An action server that needs no thread or coroutine to wait for a goal's end.

    In older rclpy versions, an executor busy-waits while a coroutine waits.
    """

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """Do nothing.  ``end`` executes the callback of the goal."""

    def end(self, goal_handle: Any, finish: Callable[[Any], Any]) -> None:
        """Call ``finish``, which returns the result, in the thread of the executor."""
        super().notify_execute(goal_handle, finish)


class SimulatedAction:
    """An action of a controller.

    The simulation accepts, executes and ends the goals.
    """

    def __init__(
        self,
        context: ControllerContext,
        kind: Any,
        name: str,
        *,
        start: Callable[[Any], Request[GoalStarted]],
        result: Callable[[Outcome], Any],
        monitor_rate: float,
    ) -> None:
        """Offer an action of class ``kind``, with feedback at ``monitor_rate`` [Hz].

        ``start`` returns the request that sends a goal's message, or raises
        RequestFailedError.  ``result`` returns the result message for an outcome.
        """
        self._context = context
        self._start, self._result = start, result
        self._rate = Rate(monitor_rate)
        self._lock = threading.Lock()
        self._started: int | None = None
        """The number of the goal that is being accepted."""
        self._active: dict[int, ActiveGoal] = {}
        self._server = _DeferringServer(
            context.node,
            kind,
            name,
            execute_callback=lambda handle: None,
            goal_callback=self._accept,
            handle_accepted_callback=self._follow,
            cancel_callback=self._cancel,
            goal_service_qos_profile=_EVERY_REQUEST,
            result_service_qos_profile=_EVERY_REQUEST,
            cancel_service_qos_profile=_EVERY_REQUEST,
        )

    @property
    def active(self) -> list[ActiveGoal]:
        """The goals that have not ended.  The newest goal is last."""
        with self._lock:
            return list(self._active.values())

    def publish(self, now: float, feedback: Callable[[ActiveGoal], Any]) -> None:
        """Publish feedback if it is due.  ``now`` is simulated time [s].

        The rate of feedback refers to wall time, as in ROS.
        """
        if not self._active or not self._rate.is_due(time.monotonic()):
            return
        for goal in self.active:
            if goal.accepted_at != goal.accepted_at or goal.accepted_at > now:
                goal.accepted_at = now
            message = feedback(goal)
            if message is not None:
                goal.handle.publish_feedback(message)

    def close(self) -> None:
        """End the action.  Goals that are still running get no result."""
        self._server.destroy()

    # ---- in the executor's thread ---------------------------------------------------

    def _accept(self, request: Any) -> GoalResponse:
        try:
            started = self._context.connection.call(self._start(request))
        except RequestFailedError as error:
            text = self._context.names.text(error)
            self._context.node.get_logger().error(f"goal rejected: {text}")
            return GoalResponse.REJECT
        self._started = started["goal"]
        return GoalResponse.ACCEPT

    def _follow(self, handle: Any) -> None:
        assert self._started is not None  # _accept was called just before this method
        number, self._started = self._started, None
        goal = ActiveGoal(number, handle)
        with self._lock:
            self._active[number] = goal
        handle.execute()
        self._context.refresh()
        self._context.connection.when_finished(number, partial(self._end, goal))

    def _cancel(self, handle: Any) -> CancelResponse:
        for goal in self.active:
            if goal.handle is handle:
                self._context.connection.submit(requests.cancel_goal(goal=goal.number))
        return CancelResponse.ACCEPT

    def _end(self, goal: ActiveGoal, outcome: Outcome) -> None:
        """End a goal.  Any thread may call this method."""
        with self._lock:
            self._active.pop(goal.number, None)
        self._server.end(goal.handle, lambda handle: self._finished(handle, outcome))

    def _finished(self, handle: Any, outcome: Outcome) -> Any:
        """Give a goal its final status, and return its result."""
        status = outcome["status"]
        if status == _SUCCEEDED:
            handle.succeed()
        elif status == _PREEMPTED and handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return self._result(outcome)
