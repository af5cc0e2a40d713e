"""Moves on a real robot: its setpoint is smooth, and goes where they say."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Awaitable, Callable, Iterator

import numpy as np
import pytest
from ur_box_rig import control_box

import tool0
from tool0.errors import ControlError, UnreachableError
from tool0.motion.moves import Move
from tool0.protocol.arm_motion import ReturnArm, StopArm, TakeArm
from tool0.protocol.control_box import SetSpeedSlider
from tool0.protocol.request import Request
from tool0.protocol.running import StopMotions
from tool0.protocol.state import Six
from tool0.ur.control_box import UrControlBox
from tool0.ur.moves import STOP, Moves
from tool0.ur.pacer import Pacer

HOME = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])
HARDEST = 40.0

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5", gripper=None, speed=0.5) as robot:
        yield robot


class Trace:
    """The setpoint at each update."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self.times: list[float] = []
        self.q: list[tuple[float, ...]] = []
        self.qd: list[tuple[float, ...]] = []
        self.paths: list[int] = []
        box.when_updated.add(self._take)

    def _take(self) -> None:
        update = self._box.arm_sample
        if self.times and self._box.time <= self.times[-1]:
            return
        self.times.append(self._box.time)
        self.q.append(self._box.target_q)
        self.qd.append(self._box.target_qd)
        self.paths.append(update.path)

    def end(self) -> None:
        self._box.when_updated.remove(self._take)

    def check_smooth(self) -> None:
        times, q, qd = (np.array(rows) for rows in (self.times, self.q, self.qd))
        dt = np.diff(times)[:, None]
        assert (np.abs(np.diff(qd, axis=0)) <= HARDEST * dt + 1e-6).all()
        mean = (qd[1:] + qd[:-1]) / 2.0
        assert (np.abs(np.diff(q, axis=0) - mean * dt) <= HARDEST * dt**2 + 1e-6).all()

    @property
    def speeds(self) -> np.ndarray:
        """The fastest joint at each update while paths are executed [rad/s]."""
        return np.abs(np.array(self.qd)).max(axis=1)


def play(
    robot: tool0.Robot, program: Callable[[UrControlBox, Moves], Awaitable[None]]
) -> Trace:
    """Execute a program from HOME; return how the setpoint moved."""

    async def run() -> Trace:
        async with control_box(robot) as box:
            await box.call(TakeArm(arm=box.arm, by="test"))
            await box.until(lambda: box.arm_sample.mode == "hold")
            moves = Moves(box)
            await moves.movej(HOME, a=6.0, v=3.0)
            trace = Trace(box)
            await program(box, moves)
            trace.end()
            await box.call(ReturnArm(arm=box.arm))
            return trace

    trace = asyncio.run(run())
    trace.check_smooth()
    return trace


def lifted(box: UrControlBox, *xyz: float) -> list[float]:
    """Return the pose at HOME, displaced."""
    pose = np.array(box.forward(HOME))
    pose[:3] += xyz
    return pose.tolist()


def panned(angle: float) -> Six:
    """Return HOME with another first joint [rad]."""
    a, b, c, d, e, f = HOME.tolist()
    return (a + angle, b, c, d, e, f)


def check_at(box: UrControlBox, q: object, tolerance: float = 1e-9) -> None:
    assert box.arm_sample.is_done
    np.testing.assert_allclose(box.target_q, q, atol=tolerance)
    np.testing.assert_allclose(box.target_qd, 0.0, atol=1e-9)


def test_movej_returns_when_it_has_ended(robot: tool0.Robot) -> None:
    target = HOME + np.array([0.35, 0.1, 0.0, 0.0, 0.2, -0.35])

    async def program(box: UrControlBox, moves: Moves) -> None:
        start = box.time
        await moves.movej(target.tolist(), a=1.4, v=1.05)
        check_at(box, target)
        assert box.time - start >= 2.0 * np.sqrt(0.35 / 1.4) - 1e-3

    play(robot, program)


def test_a_path_is_blended_and_reports_its_moves(robot: tool0.Robot) -> None:
    begun: list[int] = []

    async def program(box: UrControlBox, moves: Moves) -> None:
        aim = {"a": 2.0, "v": 0.4}
        path = [
            Move(kind="joint", q=panned(0.2), a=3.0, v=1.05, r=0.02),
            Move(kind="linear", pose=lifted(box, 0.0, -0.05, -0.1), r=0.02, **aim),
            Move(kind="process", pose=lifted(box, 0.1, -0.05, -0.1), **aim),
        ]
        await moves.move(path, wait=False)
        while (index := moves.progress) >= 0:
            begun.append(index)
            await box.next_update()
        pose = np.array(box.tcp_pose(target=True))
        np.testing.assert_allclose(pose[:3], lifted(box, 0.1, -0.05, -0.1)[:3])

    trace = play(robot, program)
    assert [index for index, _ in itertools.groupby(begun)] == [0, 1, 2]
    moving = np.flatnonzero(trace.speeds > 0.02)
    assert np.diff(moving).max() == 1  # without a stop


@pytest.mark.parametrize("pause", [0.0, 0.05, 0.5])
def test_a_move_that_comes_later_is_blended_or_starts_at_rest(
    robot: tool0.Robot, pause: float
) -> None:
    async def program(box: UrControlBox, moves: Moves) -> None:
        await moves.movel(lifted(box, 0.0, 0.0, -0.1), a=3.0, v=0.3, r=0.04)
        await Pacer(box).wait(pause)
        await moves.movel(lifted(box, 0.1, 0.0, -0.1), a=3.0, v=0.3, r=0.04)
        await moves.movej(panned(0.1), a=3.0, v=1.05)
        check_at(box, panned(0.1))

    trace = play(robot, program)
    gaps = np.diff(np.flatnonzero(trace.speeds > 1e-3))
    if pause == 0.0:
        assert gaps.max() == 1
    elif pause == 0.5:
        assert gaps.max() > 100


def test_without_another_move_it_ends_at_its_target(robot: tool0.Robot) -> None:
    target = panned(0.2)

    async def program(box: UrControlBox, moves: Moves) -> None:
        await moves.movej(target, a=1.4, v=1.05, r=0.05)
        assert not box.arm_sample.is_done
        await box.until(lambda: box.arm_sample.is_done)
        check_at(box, target)

    play(robot, program)


def test_an_impossible_move_moves_nothing(robot: tool0.Robot) -> None:
    async def program(box: UrControlBox, moves: Moves) -> None:
        with pytest.raises(UnreachableError, match=r"move 2 \(movel\).*out of reach"):
            await moves.move(
                [
                    Move(kind="joint", q=panned(0.1), a=1.4, v=1.0),
                    Move(kind="linear", pose=lifted(box, 0, 0, 1.0), a=3.0, v=0.35),
                ]
            )
        check_at(box, HOME)

    play(robot, program)


def test_a_cancelled_move_slows_down(robot: tool0.Robot) -> None:
    async def program(box: UrControlBox, moves: Moves) -> None:
        task = asyncio.create_task(moves.movej(panned(1.0), 1.4, 1.05))
        await box.until(lambda: box.target_qd[0] > 0.3)
        task.cancel()
        await asyncio.wait([task])
        await box.until(lambda: box.arm_sample.mode == "stop")
        await box.until(lambda: box.arm_sample.is_done)
        assert 0.0 < box.target_q[0] < 0.2 + 0.5**2 / STOP

    play(robot, program)


async def begun(box: UrControlBox, moves: Moves) -> asyncio.Task[None]:
    """Return a move along which the arm is moving."""
    move = asyncio.create_task(moves.movej(panned(1.0), a=1.4, v=1.05))
    await box.until(lambda: box.target_qd[0] > 0.3)
    return move


@pytest.mark.parametrize("stop", [StopArm(), StopMotions(), ReturnArm()])
def test_a_move_that_another_client_stops_is_not_done(
    robot: tool0.Robot, stop: Request[object]
) -> None:
    async def program(box: UrControlBox, moves: Moves) -> None:
        move = await begun(box, moves)
        await box.call(stop)
        with pytest.raises(ControlError, match="stopped before its end"):
            await move
        await box.call(ReturnArm())
        await box.until(lambda: not box.state.taken_by)

    play(robot, program)


def test_a_thread_of_the_program_may_stop_a_move(robot: tool0.Robot) -> None:
    async def program(box: UrControlBox, moves: Moves) -> None:
        move = await begun(box, moves)
        await moves.stopj(STOP)
        await move

    play(robot, program)


def test_streams_and_stops(robot: tool0.Robot) -> None:
    async def program(box: UrControlBox, moves: Moves) -> None:
        for k in range(50):
            await moves.servoj(panned(0.05 * np.sin(k / 20)))
        assert box.arm_sample.mode == "servo"
        # Any motion that has not ended is stopped before a move.
        await moves.movej(HOME.tolist(), a=4.0, v=1.05)
        check_at(box, HOME)
        await moves.speedj((0.2, 0.0, 0.0, 0.0, 0.0, 0.0), a=2.0)
        await box.until(lambda: box.target_qd[0] > 0.2 - 1e-6)
        await moves.stopj(2.0)
        assert box.arm_sample.is_done
        await moves.speedl((0.0, 0.0, -0.05, 0.0, 0.0, 0.0), a=0.5, t=0.15)
        speed = box.tcp_speed(target=True)
        np.testing.assert_allclose(speed, [0, 0, -0.05, 0, 0, 0], atol=1e-3)
        await moves.stopl(1.0)
        assert box.arm_sample.is_done

    play(robot, program)


def test_movec_and_movep_and_servoc(robot: tool0.Robot) -> None:
    async def program(box: UrControlBox, moves: Moves) -> None:
        await moves.movep(lifted(box, 0.0, 0.05, 0.0), a=3.0, v=0.3, r=0.01)
        via, end = lifted(box, 0.04, 0.09, 0.0), lifted(box, 0.0, 0.13, 0.0)
        await moves.movec(via, end, a=3.0, v=0.3, r=0.01)
        await moves.servoc(lifted(box, 0.0, 0.1, -0.05), a=3.0, v=0.3)
        pose = np.array(box.tcp_pose(target=True))
        np.testing.assert_allclose(pose[:3], lifted(box, 0.0, 0.1, -0.05)[:3])

    play(robot, program)  # what is planned for the first time comes late
    trace = play(robot, program)
    assert len(set(itertools.dropwhile(lambda path: path < 2, trace.paths))) >= 3


def test_steps_of_velocities_add_up_at_any_speed_scaling(robot: tool0.Robot) -> None:
    """Steps of one period, as programs that interpolate send them."""
    step, n = 0.008, 100
    speeds = 0.3 * np.sin(np.linspace(0.0, np.pi, n)) ** 2

    async def program(box: UrControlBox, moves: Moves) -> None:
        await box.call(SetSpeedSlider(arm=box.arm, fraction=0.5))
        await box.until(lambda: box.state.speed_scaling == 0.5)
        start, before = box.time, 0.0
        for v in speeds:
            a = max(abs(v - before), 1e-6) / step
            await moves.speedj((v, 0.0, 0.0, 0.0, 0.0, 0.0), a, step)
            before = v
        assert box.time - start == pytest.approx(n * step / 0.5, abs=0.1)
        await moves.stopj(10.0)
        await box.call(SetSpeedSlider(arm=box.arm, fraction=1.0))
        moved = np.subtract(box.target_q, HOME)
        assert moved[0] == pytest.approx(speeds.sum() * step, abs=0.005)

    play(robot, program)
