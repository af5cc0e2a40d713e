"""Programs that clients send, and the stops among them."""

from __future__ import annotations

import asyncio

import pytest
from ur_box_rig import control_box

import tool0
from tool0.protocol.control_box_state import RobotMode
from tool0.ur.client_interface.scripts import UNNAMED, Script
from tool0.ur.client_interface.uploads import Uploads
from tool0.ur.messages import Message, MessageKind
from tool0.ur.program_watch import ProgramWatch

LONG = 30.0  # [wall s]; only a failing test waits so long


def waiting(name: str) -> Script:
    return Script(f"def {name}():\n  while True:\n    sync()\n  end\nend\n", name)


def line(text: str) -> Script:
    return Script(f"{text}\n", UNNAMED)


def test_a_stop_waits_behind_no_program_and_none_starts_after_it() -> None:
    async def scenario(robot: tool0.Robot) -> list[str]:
        async with control_box(robot) as box:
            errors: asyncio.Queue[str] = asyncio.Queue()
            box.messages.listeners.add(
                lambda message: (
                    errors.put_nowait(message.text)
                    if message.kind is MessageKind.ERROR
                    else None
                )
            )
            uploads = Uploads(box)
            for number in range(5):
                uploads.put(waiting(f"program_{number}"))
            uploads.put(line("stop program"))
            refused = [await asyncio.wait_for(errors.get(), LONG) for _ in range(5)]
            assert not box.programs.is_running
            uploads.put(waiting("new"))
            await asyncio.wait_for(box.until(lambda: box.programs.is_running), LONG)
            assert box.programs.name == "new"
            await box.programs.stop()
            await uploads.close()
            return refused

    with tool0.bringup(arm="ur5e", ros2_control=True) as robot:
        refused = asyncio.run(scenario(robot))
    for number, text in enumerate(refused):
        assert text.startswith(f"program_{number}: not started, since a stop")


def test_a_program_that_is_sent_with_a_stop_before_it_is_started() -> None:
    async def scenario(robot: tool0.Robot) -> None:
        async with control_box(robot) as box:
            uploads = Uploads(box)
            for name in ("first", "second"):
                uploads.put(line("stop program"))
                uploads.put(waiting(name))
                await asyncio.wait_for(
                    box.until(
                        lambda name=name: (
                            box.programs.is_running and box.programs.name == name
                        )
                    ),
                    LONG,
                )
            await box.next_update()
            assert box.programs.is_running
            await uploads.close()
            await box.programs.stop()

    with tool0.bringup(arm="ur5e", ros2_control=True) as robot:
        asyncio.run(scenario(robot))


def test_a_protective_stop_is_a_warning_with_a_number_and_is_unlocked_at_once() -> None:
    async def scenario(robot: tool0.Robot) -> list[Message]:
        async with control_box(robot) as box:
            watch = ProgramWatch(box)
            await watch.start("", 0)
            errors: list[Message] = []
            box.messages.listeners.add(
                lambda m: errors.append(m) if m.kind is MessageKind.ERROR else None
            )
            uploads = Uploads(box)
            uploads.put(line("protective_stop()"))
            stopped = lambda: bool(box.state.protective_stop)  # noqa: E731
            await asyncio.wait_for(box.until(stopped), LONG)
            await asyncio.wait_for(box.until(lambda: bool(errors)), LONG)
            uploads.put(line("set unlock protective stop"))
            await asyncio.wait_for(box.until(lambda: not stopped()), LONG)
            await uploads.close()
            await watch.close()
            return errors

    with tool0.bringup(arm="ur5e", ros2_control=True) as robot:
        (error,) = asyncio.run(scenario(robot))
        assert (error.code, error.is_warning) == (209, True)
        with pytest.raises(tool0.ControlError, match="is not in a protective stop"):
            robot.arm.control_box.unlock()


@pytest.mark.parametrize("count", [1, 40])
def test_power_on_before_power_off_leaves_the_arm_off(count: int) -> None:
    async def scenario(robot: tool0.Robot) -> None:
        async with control_box(robot) as box:
            uploads = Uploads(box)
            for _ in range(count):
                uploads.put(line("power on"))
            uploads.put(line("power off"))
            off = lambda: box.state.robot_mode is RobotMode.POWER_OFF  # noqa: E731
            await asyncio.wait_for(box.until(off), LONG)
            while uploads._waiting:
                await box.next_update()
            await box.next_update()
            assert off()
            await uploads.close()

    with tool0.bringup(arm="ur5e", ros2_control=True) as robot:
        asyncio.run(scenario(robot))
