"""The loop: drain the mailbox, tick, publish; in its own thread or in the caller's.

Whoever holds the lock owns the tick.  In real time a thread of the loop's own holds it
for life; otherwise the thread that asks for progress takes it for as long as it asks.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any, final

from tool0.control.goal import Goal
from tool0.errors import ControlError, EngineError
from tool0.runtime import commands as ask
from tool0.runtime.bus import (
    SNAPSHOT_PERIOD,
    Bus,
    Faulted,
    GoalFinished,
    Overran,
    Snapshot,
    WasReset,
)
from tool0.runtime.clock import Pacer, SpeedMeter
from tool0.runtime.core import Core
from tool0.runtime.mailbox import Mailbox
from tool0.sensing.grasp_assist import GraspAssist

logger = logging.getLogger(__name__)

_PATIENCE = 0.05  # [wall s] between looks at whether the loop still lives


@final
class Loop:
    """Owns the time of one core."""

    def __init__(
        self,
        core: Core,
        mailbox: Mailbox,
        bus: Bus,
        *,
        paused: bool = False,
        speed: float | None = None,
    ) -> None:
        """Publish the first snapshot; nothing runs yet.

        Args:
            core: What to step.
            mailbox: Where commands come from.
            bus: Where snapshots go.
            paused: Whether to begin paused.
            speed: Simulated seconds per wall second; None runs only when asked, as
                fast as possible.
        """
        self._core = core
        self._mailbox = mailbox
        self._bus = bus
        self._is_paused = paused
        self._speed = None if speed is None else _checked_speed(speed)
        self._pacer = Pacer(core.control_period, speed or 1.0)
        self._meter = SpeedMeter()
        self._overruns_told = 0
        self._snapshot_ticks = max(1, round(SNAPSHOT_PERIOD / core.control_period))
        self._owner = threading.RLock()
        self._closing = False
        self._fault: Exception | None = None
        self._look_at_state()
        self.steps = 0
        """Ticks since the start; unlike time, no reset sets it back."""
        self.max_drift = 0.0
        """Largest departure of an uncommanded joint from its initial pose so far."""
        core.when_goal_starts = self._announce_when_finished
        self._publish()
        self._thread: threading.Thread | None = None
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
        """Simulated time of a tick [s]."""
        return self._core.control_period

    @property
    def overruns(self) -> int:
        return self._pacer.overruns

    @property
    def is_realtime(self) -> bool:
        return self._thread is not None

    @property
    def is_closed(self) -> bool:
        return self._closing

    def call(self, command: ask.Command) -> Any:  # the answer is the command's
        """Post ``command`` and return its answer, or raise what it raises."""
        if self._closing:
            raise ControlError("the simulation is closed")
        future = self._mailbox.post(command)
        while True:
            if self._thread is None and self._owner.acquire(blocking=False):
                try:
                    self._drain()
                finally:
                    self._owner.release()
            try:
                return future.result(_PATIENCE)
            except FutureTimeoutError:
                if self._closing:
                    raise ControlError("the simulation was closed") from None

    def run(self, duration: float, until: Callable[[], bool] = lambda: False) -> None:
        """Let ``duration`` simulated seconds pass, or fewer if ``until`` says so.

        Raises:
            EngineError: If the physics failed; a reset makes it run again.
            ControlError: If the loop is paused or closed meanwhile.
        """
        end = self.steps + duration / self._core.control_period - 0.5
        while self.steps < end and not until():
            self.check()
            if self._closing:
                raise ControlError("the simulation was closed")
            if self._is_paused:
                raise ControlError("the simulation is paused; resume it, or step it")
            if self._thread is not None or not self._owner.acquire(blocking=False):
                left = (end - self.steps) * self._core.control_period
                time.sleep(min(_PATIENCE, max(left / (self._speed or 1.0), 0.0005)))
                continue
            try:
                while self.steps < end and self._is_running and not until():
                    self._cycle()
                self._publish()
            finally:
                self._owner.release()
        self.check()

    def wait_for(self, goal: Goal, timeout: float | None) -> None:
        """Wait until ``goal`` ends, at most ``timeout`` wall seconds, in real time.

        Raises:
            EngineError: If the physics failed: the goal would never end.
        """
        end = time.monotonic() + (math.inf if timeout is None else timeout)
        while not goal.wait(min(_PATIENCE, max(0.0, end - time.monotonic()))):
            self.check()
            if not time.monotonic() < end:
                return

    def close(self) -> None:
        """End the loop, and answer what is still in the mailbox; then the engine."""
        self._closing = True
        self._look_at_state()
        if self._thread is not None:
            self._thread.join()
        with self._owner:
            self._drain()
            self._core.manager.stop_all(self._core.state)
            self._core.engine.close()

    def _look_at_state(self) -> None:
        """Note whether ticks may follow each other; the tick itself asks only that."""
        self._is_running = not (
            self._is_paused or self._closing or self._fault is not None
        )

    def check(self) -> None:
        """Raise what made the simulation stand still, if it does."""
        if self._fault is not None:
            raise self._fault

    def _run_forever(self) -> None:
        with self._owner:
            while not self._closing:
                if not self._is_running:
                    self._answer(self._mailbox.take(timeout=_PATIENCE))
                    continue
                if (wait := self._pacer.wait_time()) > 0.0:
                    self._answer(self._mailbox.take(timeout=min(wait, _PATIENCE)))
                    continue
                self._pacer.tick()
                self._cycle()

    def _cycle(self) -> None:
        """Drain; then tick, unless a letter said to stand still."""
        if self._mailbox:
            self._drain()
            if not self._is_running:
                return
        self._tick()

    def _tick(self) -> None:
        """Tick, and publish when it is time to."""
        core = self._core
        try:
            core.tick()
        except Exception as error:  # a bug in a controller must not lose the robot
            if not isinstance(error, EngineError):
                logger.exception("the control tick failed")
            self._stand_still(error)
        self.steps += 1
        if core.ticks % self._snapshot_ticks == 0:
            self._publish()
            if core.grasp_assist is not None:
                self._assist(core.grasp_assist)

    def _assist(self, grasp_assist: GraspAssist) -> None:
        """Let what is held be attached, and what is not be detached."""
        snapshot = self._bus.latest
        if snapshot is None or self._fault is not None:
            return
        try:
            grasp_assist.look(snapshot)
        except Exception as error:  # whatever the engine says of it
            self._stand_still(error)

    def _stand_still(self, error: Exception) -> None:
        self._fault = error
        self._look_at_state()
        self._bus.announce(Faulted(str(error), self._core.time))
        self._publish()

    def _drain(self) -> None:
        while (letter := self._mailbox.take()) is not None:
            self._answer(letter)

    def _answer(self, letter: tuple[ask.Command, Future[Any]] | None) -> None:
        if letter is None:
            return
        command, future = letter
        if not future.set_running_or_notify_cancel():
            return
        if self._closing:
            future.set_exception(ControlError("the simulation was closed"))
            return
        try:
            answer = self._apply(command)
        except Exception as error:  # the asker's affair, whatever it is
            future.set_exception(error)
        else:
            future.set_result(answer)

    def _apply(self, command: ask.Command) -> Any:  # the answer is the command's
        match command:
            case ask.SetPaused(paused):
                self._is_paused = paused
                self._look_at_state()
                self._restart_clock()
            case ask.SetSpeed(factor):
                self._set_speed(factor)
            case ask.Step(ticks):
                self._step(ticks)
            case ask.Reset():
                self._core.apply(command)
                self._fault = None
                self._look_at_state()
                self._restart_clock()
                self._bus.announce(WasReset(self._core.time))
            case (
                ask.QueryState()
                | ask.ReadController()
                | ask.ReadSpec()
                | ask.ReadContacts()
                | ask.StartSensor()
                | ask.StopSensor()
            ):  # nothing to publish: who reads after each snapshot must not cause one
                return self._core.apply(command)
            case _:
                answer = self._core.apply(command)
                self._publish()
                return answer
        self._publish()
        return None

    def _set_speed(self, factor: float) -> None:
        if self._speed is None:
            raise ControlError("this simulation does not run in real time")
        self._speed = _checked_speed(factor)
        self._restart_clock()

    def _step(self, ticks: int) -> None:
        if not self._is_paused:
            raise ControlError("pause the simulation before stepping it")
        if not 0 < ticks <= 1_000_000:
            raise ControlError(f"ticks must be in 1 … 1000000, got {ticks}")
        self.check()
        for _ in range(ticks):
            self._drain()
            if self._closing or self._fault is not None:
                break
            self._tick()
        self.check()

    def _restart_clock(self) -> None:
        overruns = self._pacer.overruns
        self._pacer = Pacer(self._core.control_period, self._speed or 1.0)
        self._pacer.overruns = overruns

    def _announce_when_finished(self, goal: Goal) -> None:
        goal.when_finished(lambda done: self._bus.announce(GoalFinished(done)))

    def _publish(self) -> None:
        core = self._core
        self.max_drift = max(self.max_drift, core.drift())
        if self._meter.measure(core.time):
            self._tell_overruns()
        state = core.state
        self._bus.publish(
            Snapshot(
                time=core.time,
                tick=core.ticks,
                joint_names=core.hardware.joint_names,
                position=tuple(state.position),
                velocity=tuple(state.velocity),
                effort=tuple(state.effort),
                controllers=core.manager.list(),
                is_paused=self._is_paused,
                is_stopped=core.hardware.is_stopped,
                real_time_factor=self._meter.factor,
                overruns=self._pacer.overruns,
                fault=None if self._fault is None else str(self._fault),
                speed=self._speed,
                intents=core.manager.intents(),
                scene=core.surroundings.objects,
                objects=core.engine.world.object_states(),
            )
        )

    def _tell_overruns(self) -> None:
        count = self._pacer.overruns - self._overruns_told
        if count and self.is_realtime:
            self._overruns_told = self._pacer.overruns
            self._bus.announce(Overran(count, self._core.time))
            logger.warning("%d ticks began late in the last second", count)


def _checked_speed(factor: float) -> float:
    if not 0.0 < factor <= 1000.0:
        raise ControlError(f"speed must be in (0, 1000], got {factor}")
    return factor
