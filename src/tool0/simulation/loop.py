"""The loop, which executes queued operations and ticks, and publishes snapshots.

The mailbox is the only input.  The mailbox receives operations from any thread; the
thread of the tick executes each operation between two ticks.  In real time, the thread
of the tick is a dedicated thread of the loop.  Without real time, the thread of the
tick is the caller's thread while the caller advances time.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from functools import partial
from typing import Any, NamedTuple, TypeVar, final

from tool0.errors import ControlError, EngineError
from tool0.protocol.bus import Bus, Faulted, GoalFinished, WasReset
from tool0.protocol.freeze_meter import FreezeMeter
from tool0.protocol.goals import Goal
from tool0.protocol.state import SNAPSHOT_PERIOD, Snapshot, ticks_between_snapshots
from tool0.simulation.clock import FollowedClock, Pacer
from tool0.simulation.executor import Executor
from tool0.simulation.mailbox import Mailbox
from tool0.simulation.publisher import Publisher

logger = logging.getLogger(__name__)

POLL_PERIOD = 0.05
"""Longest wall time between checks of whether the loop is still running [s]."""

R = TypeVar("R")


class _Operation(NamedTuple):
    run: Callable[[], Any]
    future: Future[Any]
    publishes: bool


@final
class Loop:
    """Controls the time of one core."""

    def __init__(
        self,
        executor: Executor,
        bus: Bus,
        *,
        paused: bool = False,
        speed: float | None = None,
    ) -> None:
        """Publish the first snapshot, and start the thread of the loop in real time.

        ``speed`` is the ratio of simulated time to wall time.  If ``speed`` is None,
        the loop does not run in real time: time passes only on request, as fast as
        possible.
        """
        self._executor = executor
        self._core = core = executor.core
        self._mailbox: Mailbox[_Operation | None] = Mailbox()
        """Queued operations.  An item of None wakes the thread of the tick for an
        urgent operation."""
        self._urgent: deque[_Operation] = deque()
        """Urgent operations, which are executed before the operations in the
        mailbox."""
        self._bus = bus
        self.is_paused = paused
        self.speed = None if speed is None else _checked_speed(speed)
        self._pacer = self._clock()
        self._publisher = Publisher(core, bus)
        default = ticks_between_snapshots(SNAPSHOT_PERIOD, core.control_period)
        self._default_snapshot_ticks = self._snapshot_ticks = default
        self._owner = threading.RLock()
        self._closing = False
        self.fault: Exception | None = None
        self._update_running()
        self.steps = 0
        """Number of ticks since the start; a reset does not set this number to 0."""
        self.when_observed: Callable[[Snapshot], None] = lambda snapshot: None
        """Function that is called between two ticks after snapshots at the default
        period."""
        self.when_frozen: Callable[[float], None] = lambda duration: None
        """Function that is called in real time before the next tick if the process was
        frozen.  The argument is the duration of the freeze in wall time [s].  The
        function is not called for an engine in a separate process, which may be delayed
        independently."""
        executor.when_goal_starts = lambda goal: goal.when_finished(
            lambda done: bus.announce(GoalFinished(done, core.time))
        )
        self._thread: threading.Thread | None = None
        self._publish()
        if speed is not None:
            self._thread = threading.Thread(
                target=self._run_forever, name="tool0 loop", daemon=True
            )
            self._thread.start()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._core.time

    @property
    def control_period(self) -> float:
        """Simulated time per tick [s]."""
        return self._core.control_period

    @property
    def overruns(self) -> int:
        return self._pacer.overruns

    @property
    def max_drift(self) -> float:
        """Largest drift of an uncommanded joint from its start position [rad | m]."""
        return self._publisher.max_drift

    @property
    def is_realtime(self) -> bool:
        return self._thread is not None

    @property
    def is_closed(self) -> bool:
        return self._closing

    def call(
        self,
        operation: Callable[[], R],
        *,
        publishes: bool = True,
        urgent: bool = False,
    ) -> R:
        """Execute ``operation`` between two ticks, and return its result.

        The operation runs in the thread of the tick.  The thread of the tick may also
        use ``call`` between two ticks.  If ``publishes`` is True, a snapshot is
        published after the operation.  An urgent operation waits only for the operation
        in progress.

        Raises:
            ControlError: If the simulation is closed.
        """
        if self._closing:
            raise ControlError("the simulation is closed")
        future: Future[R] = Future()
        if urgent:
            self._urgent.append(_Operation(operation, future, publishes))
            self._mailbox.put(None)
        else:
            self._mailbox.put(_Operation(operation, future, publishes))
        while True:
            is_own = self._thread in {None, threading.current_thread()}
            if is_own and self._owner.acquire(blocking=False):
                try:
                    self._drain()
                finally:
                    self._owner.release()
            try:
                return future.result(POLL_PERIOD)
            except FutureTimeoutError:
                if self._closing:
                    raise ControlError("the simulation was closed") from None

    def post(
        self, operation: Callable[[], object], when_failed: Callable[[Exception], None]
    ) -> None:
        """Queue ``operation`` for execution before the next tick, without waiting.

        If the operation raises an exception, ``when_failed`` is called with the
        exception in the thread of the tick.

        Raises:
            ControlError: If the simulation is closed.
        """
        if self._closing:
            raise ControlError("the simulation is closed")

        def note(future: Future[object]) -> None:
            error = future.exception()
            if isinstance(error, Exception):
                when_failed(error)

        future: Future[object] = Future()
        future.add_done_callback(note)
        self._mailbox.put(_Operation(operation, future, publishes=False))

    def run(self, duration: float, until: Callable[[], bool] = lambda: False) -> None:
        """Advance time by ``duration`` [s], or stop early if ``until`` returns True.

        ``until`` is called at every snapshot and when a goal ends, but not after every
        tick.

        Raises:
            EngineError: If the physics engine failed; the engine runs again after a
                reset.
            ControlError: If the loop is paused or closed before the end.
        """
        end = self.steps + duration / self._core.control_period - 0.5
        while self.steps < end and not until():
            self.check()
            if self._closing:
                raise ControlError("the simulation was closed")
            if self.is_paused:
                raise ControlError("the simulation is paused; resume it, or step it")
            if self._thread is not None or not self._owner.acquire(blocking=False):
                left = (end - self.steps) * self._core.control_period
                time.sleep(min(POLL_PERIOD, max(left / (self.speed or 1.0), 0.0005)))
                continue
            try:
                while self.steps < end and self._is_running and not until():
                    self._cycle(end - self.steps)
                self._publish()
            finally:
                self._owner.release()
        self.check()

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        """Advance time until ``goal`` ends, and return whether it has ended.

        ``timeout`` [s] is in wall time if the loop runs in real time, and in simulated
        time otherwise.  If ``timeout`` is None, there is no timeout.

        Raises:
            EngineError: If the physics engine failed, so that the goal would never end.
            ControlError: If the loop is closed, or if it is paused and does not run in
                real time.
        """
        limit = math.inf if timeout is None else timeout
        if goal.status.is_terminal:
            return True
        if not self.is_realtime:
            self.run(limit, until=lambda: goal.status.is_terminal)
            return goal.status.is_terminal
        end = time.monotonic() + limit
        while not goal.wait(min(POLL_PERIOD, max(0.0, end - time.monotonic()))):
            self.check()
            if not time.monotonic() < end:
                return False
        return True

    def set_paused(self, paused: bool) -> None:
        """Pause or resume simulated time, in the thread of the tick."""
        self.is_paused = paused
        self._update_running()
        self._restart_clock()

    def set_speed(self, factor: float) -> None:
        """Run at ``factor`` times real time, in the thread of the tick."""
        if self.speed is None:
            raise ControlError("this simulation does not run in real time")
        self.speed = _checked_speed(factor)
        self._restart_clock()

    def step(self, ticks: int) -> None:
        """Run ``ticks`` control periods while paused, in the thread of the tick."""
        if not self.is_paused:
            raise ControlError("pause the simulation before stepping it")
        self.check()
        end = self.steps + ticks
        while self.steps < end:
            self._drain()
            if self._closing or self.fault is not None:
                break
            self._tick(end - self.steps)
        self.check()

    def reset(self, position: Mapping[str, float], keep_time: bool) -> None:
        """Reset the core and clear a fault, in the thread of the tick."""
        self._core.reset(position, keep_time)
        self._executor.supervision.forget()
        self.fault = None
        self._update_running()
        self._restart_clock()
        self._bus.announce(WasReset(self._core.time, self.steps))

    def publish_every(self, period: float) -> float:
        """Publish snapshots at least every ``period`` [s]; return the actual period.

        ``publish_every`` must be called in the thread of the tick.  The actual period
        is the longest period, up to ``period``, that is a multiple of the control
        period and divides the default period.
        """
        control_period = self._core.control_period
        self._snapshot_ticks = ticks_between_snapshots(period, control_period)
        return self._snapshot_ticks * control_period

    def close(self) -> None:
        """End the loop, answer the remaining operations, and close the engine."""
        self._closing = True
        self._update_running()
        if self._thread is not None:
            self._thread.join()
        with self._owner:
            self._drain()
            self._core.sync_from_kernel()
            self._core.manager.stop_all(self._core.state)
            self._core.engine.close()

    def _update_running(self) -> None:
        """Record whether the loop may tick automatically.

        The tick checks only the recorded flag.
        """
        self._is_running = not (
            self.is_paused or self._closing or self.fault is not None
        )

    def check(self) -> None:
        """Raise the error that has stopped the simulation, if there is one."""
        if self.fault is not None:
            raise self.fault

    def _run_forever(self) -> None:
        freeze = None if self._core.engine.stepper is None else FreezeMeter()
        with self._owner:
            while not self._closing:
                if freeze is not None and (duration := freeze.look()):
                    self._attempt(partial(self.when_frozen, duration))
                if not self._is_running:
                    self._answer_next(POLL_PERIOD)
                    continue
                if (wait := self._pacer.wait_time()) > 0.0:
                    self._answer_next(min(wait, POLL_PERIOD))
                    continue
                start, pacer = self.steps, self._pacer
                self._cycle(pacer.tick())
                pacer.tick_further(self.steps - start - 1)

    def _cycle(self, most: float) -> None:
        """Execute queued operations, and tick up to ``most`` times.

        The loop does not tick if an operation has paused it.
        """
        if self._mailbox:
            self._drain()
            if not self._is_running:
                return
        self._tick(most)

    def _tick(self, most: float) -> None:
        """Tick up to ``most`` times or until the next snapshot, which is published."""
        core, start = self._core, self._core.ticks
        left = self._snapshot_ticks - start % self._snapshot_ticks
        try:
            done = core.advance(math.ceil(min(most, left)))
        except Exception as error:  # a controller's bug must not end the loop
            if not isinstance(error, EngineError):
                logger.exception("the control tick failed")
            done = core.ticks - start + 1
            self._fail(error)
        self.steps += done
        if core.ticks % self._snapshot_ticks == 0:
            self._observe()

    def _observe(self) -> None:
        """Publish a snapshot.

        At the default period, limits and contacts are also checked.

        Checks of limits and contacts therefore do not depend on the rates of
        subscribers.
        """
        core = self._core
        if core.ticks % self._default_snapshot_ticks:
            self._publish()
            return
        self._attempt(self._executor.supervise)
        self._attempt(core.check_contacts)
        self._publish()
        snapshot, grasp_assist = self._bus.latest, core.grasp_assist
        if grasp_assist is not None and snapshot is not None:
            self._attempt(lambda: grasp_assist.look(snapshot))
        if snapshot is not None and self.fault is None:
            self.when_observed(snapshot)

    def _attempt(self, action: Callable[[], None]) -> None:
        """Call, outside the tick, an action that uses the engine and may fail."""
        if self.fault is not None:
            return
        try:
            action()
        except Exception as error:  # any engine may fail
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        """Stop ticking until a reset, and publish the reason."""
        self.fault = error
        self._update_running()
        self._bus.announce(Faulted(str(error), self._core.time))
        self._publish()

    def _answer_next(self, timeout: float) -> None:
        self._mailbox.wait(timeout)
        for operation in self._mailbox.take():
            self._answer(operation)

    def _drain(self) -> None:
        """Execute the queued operations.

        Operations that are queued later are executed after the next tick.
        """
        for _ in range(len(self._mailbox)):
            # An operation may execute the remaining queued operations.
            for operation in self._mailbox.take():
                self._answer(operation)

    def _answer(self, operation: _Operation | None) -> None:
        """Execute urgent operations, and then ``operation``."""
        while self._urgent:
            self._carry_out(self._urgent.popleft())
        if operation is not None:
            self._carry_out(operation)

    def _carry_out(self, operation: _Operation) -> None:
        run, future, publishes = operation
        self._core.sync_from_kernel()
        if not future.set_running_or_notify_cancel():
            return
        if self._closing:
            future.set_exception(ControlError("the simulation was closed"))
            return
        try:
            answer = run()
            if publishes:
                self._publish()
        except Exception as error:  # affects only the caller
            future.set_exception(error)
        else:
            future.set_result(answer)

    def _clock(self) -> Pacer | FollowedClock:
        """Return the clock that determines the due times of ticks."""
        if self._core.own_drives is not None:
            return FollowedClock()
        return Pacer(self._core.control_period, self.speed or 1.0)

    def _restart_clock(self) -> None:
        overruns = self._pacer.overruns
        self._pacer = self._clock()
        self._pacer.overruns = overruns
        self._publisher.restart_meter(overruns)

    def snapshot_with_arms(self) -> Snapshot:
        """Publish a snapshot with the motion of each arm, and return it.

        Raises:
            ControlError: If the simulation is closed.
        """

        def publish() -> Snapshot:
            self._publish(with_arms=True)
            snapshot = self._bus.latest
            assert snapshot is not None  # it was just published
            return snapshot

        return self.call(publish, publishes=False)

    def refresh(self) -> None:
        """Publish a snapshot soon, without waiting, even while time is stopped.

        The snapshot has the fields that were requested since the last snapshot.
        """
        if not self._closing:
            self._mailbox.put(_Operation(self._publish, Future(), publishes=False))

    def _publish(self, *, with_arms: bool = False) -> None:
        self._publisher.publish(self, with_arms=with_arms)


def _checked_speed(factor: float) -> float:
    if not 0.0 < factor <= 1000.0:
        raise ControlError(f"speed must be in (0, 1000], got {factor}")
    return factor
