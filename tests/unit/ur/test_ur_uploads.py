"""Programs that clients send, and the stops among them."""

from __future__ import annotations

import asyncio

import pytest
from ur_box_rig import control_box

import tool0
from tool0.protocol.control_box_state import RobotMode
from tool0.ur.client_interface.scripts import UNNAMED, Script
from tool0.ur.client_interface.uploads import Uploads
from tool0.ur.messages import MessageKind

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
