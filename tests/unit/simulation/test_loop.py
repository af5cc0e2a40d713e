"""Time, threads and faults.  Nothing here sleeps: tests wait on goals and the bus."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial

import pytest
from raises_naming import raises_naming
from skew_rig import START, build_core, build_loop, follow, switch

from tool0.errors import ControlError, DivergenceError
from tool0.protocol.bus import Bus, Faulted, GoalFinished, Overran, WasReset
from tool0.protocol.goals import GoalStatus
from tool0.protocol.state import Snapshot
from tool0.simulation.clock import SpeedMeter
from tool0.simulation.core import Core
from tool0.simulation.loop import Loop

Starter = Callable[..., tuple[Loop, Bus, Core]]
LONG = 30.0  # [wall s]; only a failing test waits so long


@pytest.fixture
def start() -> Iterator[Starter]:
    """Start loops that are closed when the test ends."""
    loops = []

    def start_one(**options: object) -> tuple[Loop, Bus, Core]:
        core = build_core()
        loop, bus = build_loop(core, **options)
        loops.append(loop)
        return loop, bus, core

    yield start_one
    for loop in loops:
        loop.close()


def break_physics(core: Core) -> None:
    core.engine.data.qvel[0] = math.nan  # type: ignore[attr-defined]


def wait_until(bus: Bus, holds: Callable[[Snapshot], bool]) -> Snapshot:
    reader = bus.subscribe()
    deadline = time.monotonic() + LONG
    while time.monotonic() < deadline:
        snapshot = reader.next(timeout=LONG)
        assert snapshot is not None
        if holds(snapshot):
            return snapshot
    raise AssertionError("it never held")


# ---- as fast as possible, in the caller's thread -------------------------------------


def test_what_is_urgent_overtakes_what_waits(start: Starter) -> None:
    loop, _, _ = start()
    done: list[object] = []
    for number in range(100):
        loop.post(partial(done.append, number), pytest.fail)
    loop.call(partial(done.append, "stop"), urgent=True)
    assert done == ["stop", *range(100)]


def test_operations_that_never_cease_do_not_keep_time_from_passing(
    start: Starter,
) -> None:
    loop, _, _ = start()

    def again() -> None:
        loop.post(again, pytest.fail)

    again()
    before = loop.time
    loop.run(0.01)
    assert loop.time > before


def test_a_first_snapshot_is_there_before_anything_runs(start: Starter) -> None:
    _, bus, _ = start()
    assert bus.latest is not None
    assert (bus.latest.time, list(bus.latest.position)) == (0.0, START)
    assert [c.name for c in bus.latest.controllers if c.state == "running"] == ["arm"]


@pytest.mark.parametrize("duration", [0.0, 0.001, 0.0104, 0.3, 1.0])
def test_a_run_takes_the_simulated_time_that_was_asked_for(
    start: Starter, duration: float
) -> None:
    loop, bus, _ = start()
    loop.run(duration)
    assert loop.steps == round(duration / 0.001)
    assert loop.time == pytest.approx(duration, abs=0.0005)
    assert bus.latest is not None
    assert bus.latest.time == loop.time


def test_a_run_ends_early_with_its_goal(start: Starter) -> None:
    loop, _, core = start()
    goal = loop.call(lambda: follow(core, [0.5, 0.5], 0.2))
    ended_at: list[int] = []
    goal.when_finished(lambda _: ended_at.append(core.ticks))
    loop.run(math.inf, until=lambda: goal.status.is_terminal)
    assert ended_at == [loop.steps - 1]  # during the last tick


def test_a_command_is_answered_without_time_passing(start: Starter) -> None:
    loop, bus, core = start()
    goal = loop.call(lambda: follow(core, [0.5, 0.5], 0.2))
    assert goal.status is GoalStatus.ACTIVE
    assert loop.time == 0.0
    loop.call(lambda: switch(core, stop=("arm",)))
    assert bus.latest is not None
    states = {status.name: status.state for status in bus.latest.controllers}
    assert states["arm"] == "stopped"  # not only after the next tick


def test_reading_publishes_nothing_lest_a_reader_of_snapshots_wake_itself(
    start: Starter,
) -> None:
    loop, bus, core = start()
    before = bus.latest
    loop.call(core.engine.world.contacts, publishes=False)
    assert bus.latest is before


def test_a_goal_that_ends_is_an_event(start: Starter) -> None:
    loop, bus, core = start()
    reader = bus.subscribe()
    goal = loop.call(lambda: follow(core, [0.4, -0.2], 0.1))
    assert not reader.events
    loop.run(1.0)
    assert list(reader.events) == [GoalFinished(goal, pytest.approx(0.1))]


@pytest.mark.parametrize("speed", [None, 50.0])
def test_steps_pass_only_while_paused_and_publish(
    start: Starter, speed: float | None
) -> None:
    loop, bus, core = start(speed=speed)
    with pytest.raises(ControlError):
        loop.call(lambda: loop.step(1))
    loop.call(lambda: loop.set_paused(True))
    assert bus.latest is not None
    assert bus.latest.is_paused
    with pytest.raises(ControlError):
        loop.run(1.0)
    for n_ticks in (1, 5, 37):
        before = loop.steps
        loop.call(partial(loop.step, n_ticks))
        assert loop.steps == before + n_ticks
        assert bus.latest.tick == loop.steps
    goal = loop.call(lambda: follow(core, [0.5, 0.5], 0.2))
    assert goal.status is GoalStatus.ACTIVE
    assert loop.steps == before + n_ticks
    loop.call(lambda: loop.set_paused(False))
    loop.run(0.01)
    assert loop.steps >= before + 37 + 10


def test_a_reset_is_an_event_and_steps_count_on(start: Starter) -> None:
    loop, bus, _ = start()
    reader = bus.subscribe()
    loop.run(0.2)
    loop.call(lambda: loop.reset({}, keep_time=False))
    assert list(reader.events) == [WasReset(0.0, step=200)]
    assert (loop.time, loop.steps) == (0.0, 200)
    loop.run(0.1)
    assert loop.time == pytest.approx(0.1)
    assert loop.steps == 300


# ---- faults --------------------------------------------------------------------------


def test_a_fault_stands_still_tells_and_is_mended_by_a_reset(start: Starter) -> None:
    loop, bus, core = start()
    reader = bus.subscribe()
    goal = loop.call(lambda: follow(core, [1.0, 1.0], 0.5))
    loop.run(0.1)
    break_physics(core)
    for _ in range(2):
        with raises_naming(DivergenceError, "'lift'", "0.101"):
            loop.run(0.1)
    with pytest.raises(DivergenceError):
        loop.wait_for_goal(goal, 1.0)
    assert bus.latest is not None
    assert "lift" in str(bus.latest.fault)
    assert math.isfinite(sum(bus.latest.position))  # the last state that was sound
    assert [type(event) for event in reader.events] == [Faulted]
    loop.call(lambda: loop.reset({}, keep_time=False))
    assert goal.status is GoalStatus.PREEMPTED
    assert bus.latest.fault is None
    assert loop.wait_for_goal(goal, None)
    loop.run(1.0)
    assert core.state.position == pytest.approx(START, abs=1e-3)


def test_a_bug_in_the_tick_is_a_fault_too(
    start: Starter, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop, bus, core = start()

    def fail(*_: object) -> None:
        raise ZeroDivisionError("a bug")

    with monkeypatch.context() as patch:
        patch.setattr("tool0.simulation.core.Core.advance", fail)
        with pytest.raises(ZeroDivisionError):
            loop.run(0.1)
    assert bus.latest is not None
    assert bus.latest.fault == "a bug"
    loop.call(lambda: loop.reset({}, keep_time=False))
    loop.run(0.1)
    assert core.time == pytest.approx(0.1)


# ---- closing -------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [None, 1.0])
def test_closing_ends_goals_and_waits_and_refuses_what_comes_later(
    start: Starter, speed: float | None
) -> None:
    loop, bus, core = start(speed=speed)
    goal = loop.call(lambda: follow(core, [1.0, 1.0], 1e6))
    outcome: list[object] = []

    def wait() -> None:
        try:
            outcome.append(loop.wait_for_goal(goal, None))
        except ControlError as error:
            outcome.append(type(error))

    waiter = threading.Thread(target=wait)
    waiter.start()
    wait_until(bus, lambda snapshot: snapshot.time > 0.01)
    loop.close()
    waiter.join(LONG)
    assert goal.status is GoalStatus.PREEMPTED
    assert outcome == [True if speed else ControlError]
    for late in (
        lambda: loop.call(lambda: loop.set_paused(True)),
        lambda: loop.run(1.0),
    ):
        with pytest.raises(ControlError):
            late()
    loop.close()
    assert loop.wait_for_goal(goal, None)


def test_closing_ends_a_long_step(start: Starter) -> None:
    loop, bus, _ = start(paused=True)
    stepper = threading.Thread(target=lambda: loop.call(lambda: loop.step(1_000_000)))
    stepper.start()
    wait_until(bus, lambda snapshot: snapshot.time > 0.02)
    loop.close()
    stepper.join(LONG)
    assert not stepper.is_alive()
    assert loop.steps < 1_000_000


# ---- many threads --------------------------------------------------------------------


def test_commands_of_many_threads_are_all_answered_while_it_runs(
    start: Starter,
) -> None:
    loop, bus, core = start()
    answers: list[object] = []
    done = threading.Event()

    def ask_much(number: int) -> None:
        for n in range(20):
            goal = loop.call(partial(follow, core, [0.01 * number, 0.01 * n], 0.1))
            answers.append(goal)

    def run() -> None:
        loop.run(math.inf, until=done.is_set)

    runner = threading.Thread(target=run)
    runner.start()
    wait_until(bus, lambda snapshot: snapshot.time > 0.0)
    askers = [threading.Thread(target=ask_much, args=(k,)) for k in range(8)]
    for asker in askers:
        asker.start()
    for asker in askers:
        asker.join(LONG)
    done.set()
    runner.join(LONG)
    assert len(answers) == 160
    states = [goal.status for goal in answers]  # type: ignore[attr-defined]
    assert GoalStatus.ABORTED not in states
    assert states.count(GoalStatus.ACTIVE) <= 1
    assert core.manager.status("arm").state == "running"


def test_a_late_loop_catches_up_in_bursts_that_end_at_snapshots(
    start: Starter, monkeypatch: pytest.MonkeyPatch
) -> None:
    bursts: list[tuple[int, int]] = []
    advance = Core.advance

    def recorded(core: Core, most: int) -> int:
        bursts.append((core.ticks, most))
        return advance(core, most)

    monkeypatch.setattr(Core, "advance", recorded)
    loop, bus, _ = start(speed=1000.0)
    wait_until(bus, lambda snapshot: snapshot.time > 1.0)
    answered_at = loop.call(lambda: loop.steps)
    wait_until(bus, lambda snapshot: snapshot.tick > answered_at)
    assert any(ticks == answered_at for ticks, _ in bursts)  # between two of them
    assert max(most for _, most in bursts) > 1
    assert all(ticks % 8 + most <= 8 for ticks, most in bursts)


def test_after_a_pause_not_one_tick_passes(start: Starter) -> None:
    loop, bus, _ = start()
    errors: list[ControlError] = []

    def run() -> None:
        try:
            loop.run(math.inf)
        except ControlError as error:
            errors.append(error)

    for _ in range(10):
        runner = threading.Thread(target=run)
        runner.start()
        begun = loop.time
        wait_until(bus, lambda snapshot, begun=begun: snapshot.time > begun)  # type: ignore[misc]
        loop.call(lambda: loop.set_paused(True))
        paused_at = loop.steps
        runner.join(LONG)
        assert loop.steps == paused_at
        loop.call(lambda: loop.set_paused(False))
    assert len(errors) == 10


# ---- real time, in a thread of its own -----------------------------------------------


def test_real_time_does_not_run_ahead_of_the_wall_clock(start: Starter) -> None:
    before = time.perf_counter()
    loop, _, _ = start(speed=2.0)
    loop.run(0.2)
    assert time.perf_counter() - before >= 0.2 / 2.0 - 0.002


@pytest.mark.slow
def test_real_time_that_is_missed_is_told_when_it_begins_and_ends(
    start: Starter, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setitem(SpeedMeter.measure.__kwdefaults__, "window", 0.02)
    loop, bus, _ = start(speed=1000.0, paused=True)  # a tick cannot take 1 µs
    reader = bus.subscribe()
    loop.call(lambda: loop.set_paused(False))
    wait_until(bus, lambda snapshot: bool(reader.events))
    missed = loop.overruns
    wait_until(bus, lambda snapshot: snapshot.overruns > 2 * missed)
    assert loop.time < 1000.0  # what cannot be caught up is given up
    loop.call(lambda: loop.set_speed(0.1))
    wait_until(bus, lambda snapshot: len(reader.events) > 1)
    loop.close()
    behind, caught_up = (event for event in reader.events if isinstance(event, Overran))
    assert behind.count > 0
    assert caught_up.count == 0
    told = [record.getMessage() for record in caplog.records]
    assert [text.partition(":")[0] for text in told] == [
        "the simulation falls behind",
        "the simulation keeps up again",
    ]


@pytest.mark.parametrize("speed", [0.0, -1.0, 1001.0, math.nan])
def test_an_impossible_speed_is_refused(start: Starter, speed: float) -> None:
    with pytest.raises(ControlError):
        start(speed=speed)
    loop, _, _ = start(speed=1.0)
    timeless, _, _ = start()
    for refused in (
        lambda: loop.call(lambda: loop.set_speed(speed)),
        lambda: timeless.call(lambda: timeless.set_speed(2.0)),
    ):
        with pytest.raises(ControlError):
            refused()


def test_a_very_slow_simulation_still_answers_and_closes_at_once(
    start: Starter,
) -> None:
    loop, bus, _ = start(speed=1e-6)  # a tick takes a quarter of an hour
    wait_until(bus, lambda snapshot: snapshot.tick >= 0)
    before = time.perf_counter()
    for _ in range(3):
        loop.call(lambda: loop.set_paused(False))
    loop.call(lambda: loop.set_speed(100.0))
    wait_until(bus, lambda snapshot: snapshot.time > 0.01)
    loop.close()
    assert time.perf_counter() - before < LONG


def test_a_fault_ends_steps_and_a_wait_in_real_time(start: Starter) -> None:
    paused, _, core = start(paused=True)
    break_physics(core)
    with pytest.raises(DivergenceError):
        paused.call(lambda: paused.step(10))
    loop, _, core = start(speed=1.0)
    goal = loop.call(lambda: follow(core, [1.0, 1.0], 500.0))
    break_physics(core)
    with pytest.raises(DivergenceError):
        loop.wait_for_goal(goal, None)
