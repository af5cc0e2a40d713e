"""Bounds that programs keep to wherever they end: what tests/fuzz has found."""

from __future__ import annotations

import asyncio
import gc
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, cast

import pytest
from stepped_box import SteppedBox
from urscript_rig import TimeBox, is_error

import tool0
from tool0.errors import ControlError
from tool0.protocol.gripper import Grip
from tool0.protocol.request import Request
from tool0.ur.control_box import UrControlBox
from tool0.ur.messages import Message
from tool0.ur.moves import Moves
from tool0.ur.urscript.execution import Execution
from tool0.ur.urscript.program import compile_program

NEAR_ITS_END = (0.0, -1.2, 1.9, -2.2708, -1.5708, 5.6)
"""Wrist 3 ends at 6.283 [rad]."""
SLANTED = (-2.0, -2.0, -1.5, -0.5, 1.5, -3.0)
"""Moving its shoulder soon changes the inertia about the base by a third [rad]."""
DEADBAND = 2e-3
"""Of the drives [rad]."""
STEPS = 2000


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5e", realtime=False, initial_pose="ready") as robot:
        yield robot


async def start(stepped: SteppedBox, text: str) -> None:
    slot = stepped.box.programs
    task = asyncio.ensure_future(slot.start(compile_program(text), slot.n_stops))
    while not task.done():
        await stepped.step()
    await task


async def stop(stepped: SteppedBox) -> None:
    task = asyncio.ensure_future(stepped.box.programs.stop())
    for _ in range(STEPS):
        if task.done() and not stepped.box.state.taken_by:
            return
        await stepped.step()
    raise AssertionError("the arm is not released")


@pytest.mark.slow
@pytest.mark.parametrize("speed", [1.5, 3.1])
@pytest.mark.parametrize("ending", ["stopped", "stopj(0.5)", "stopl(0.1)"])
def test_a_stop_short_of_the_end_of_a_range_keeps_to_it(
    robot: tool0.Robot, speed: float, ending: str
) -> None:
    move = f"movej([0, -1.2, 1.9, -2.2708, -1.5708, 6.28], a=40, v={speed})"
    if ending != "stopped":
        text = (
            f"thread move():\n{move}\nend\njob = run move()\n"
            "while get_target_joint_positions()[5] < 6.1:\nsync()\nend\n"
            f"kill job\n{ending}\nsleep(1)\n"
        )
    else:
        text = f"{move}\nsleep(1)\n"

    told: list[Message] = []

    async def run() -> float:
        stepped = SteppedBox(robot)
        stepped.box.messages.listeners.add(told.append)
        names = robot.arm.joints
        robot.reset(dict(zip(names, NEAR_ITS_END, strict=True)))
        await stepped.show()
        await start(stepped, text)
        farthest = 0.0
        for _ in range(STEPS):
            await stepped.step()
            farthest = max(farthest, stepped.box.q[5])
            if ending == "stopped" and stepped.box.target_q[5] > 6.1:
                break
            if not stepped.box.programs.is_running:
                break
        task = asyncio.ensure_future(stop(stepped))
        while not task.done():
            await stepped.step()
            farthest = max(farthest, stepped.box.q[5])
        await task
        stepped.close()
        return farthest - float(stepped.upper[5])

    excess = asyncio.run(run())
    assert not list(filter(is_error, told))
    assert excess < DEADBAND
    assert excess > -0.19, "it stopped before"


def test_a_motion_that_fails_as_its_program_ends_leaves_no_error() -> None:
    lost: list[dict[str, Any]] = []

    async def fail() -> None:
        raise ControlError("it cannot be moved there")

    async def run() -> None:
        asyncio.get_running_loop().set_exception_handler(lambda _, it: lost.append(it))
        box = cast("UrControlBox", TimeBox())
        execution = Execution("p", box, Moves(box))
        task = asyncio.create_task(execution.abortable(fail()))
        for _ in range(2):  # it has failed; nobody has been told
            await asyncio.sleep(0)
        task.cancel()
        with suppress(asyncio.CancelledError, ControlError):
            await task
        del task, execution
        gc.collect()

    asyncio.run(run())
    assert lost == []


def test_commands_of_the_gripper_do_not_pile_up(robot: tool0.Robot) -> None:
    asked: list[int] = []

    async def run() -> None:
        stepped = SteppedBox(robot)
        box, n_waiting = stepped.box, 0
        gripper, call = box.gripper, box.call
        assert gripper is not None

        async def counted(request: Request[Any]) -> Any:
            nonlocal n_waiting
            is_motion = isinstance(request, Grip)
            n_waiting += is_motion
            asked.append(n_waiting)
            try:
                return await call(request)
            finally:
                n_waiting -= is_motion

        box.call = counted  # type: ignore[method-assign]  # the gripper's link
        gripper.assume_activated()
        await start(stepped, "while True:\nrq_move(10)\nrq_move(200)\nend\n")
        for _ in range(50):
            await stepped.step()
        await stop(stepped)
        await gripper.close()
        stepped.close()

    asyncio.run(run())
    assert len(asked) > 10
    assert max(asked) == 1


def test_what_costs_much_counts_as_many_statements(robot: tool0.Robot) -> None:
    text = (
        "n = 0\nwhile True:\nn = n + 1\nwrite_output_integer_register(0, n)\n"
        "get_inverse_kin(get_actual_tcp_pose())\nend\n"
    )

    async def run() -> int:
        stepped = SteppedBox(robot)
        await stepped.show()
        await start(stepped, text)
        for _ in range(50):
            await stepped.step()
        await stop(stepped)
        stepped.close()
        return stepped.box.registers.outputs.integers[0]

    n_periods = 60  # with those of the start
    assert 50 < asyncio.run(run()) <= 4 * n_periods


@pytest.mark.parametrize("value", ["v=1e-320", "a=1e-320"])
def test_a_move_that_would_take_days_is_refused(robot: tool0.Robot, value: str) -> None:
    told: list[Message] = []

    async def run() -> None:
        stepped = SteppedBox(robot)
        stepped.box.messages.listeners.add(told.append)
        await stepped.show()
        await start(stepped, f"movej([0, -1.2, 1.9, -2.2, -1.5, 0.3], {value})\n")
        for _ in range(100):
            await stepped.step()
        await stop(stepped)
        stepped.close()

    asyncio.run(run())
    assert any("more than 1e+06 s" in str(message) for message in told), told
