"""A robot whose gripper's interfaces are served by an event loop of this process."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

from ur_address import free_host
from ur_box_rig import control_box
from urscript_rig import error_text, is_error

import tool0
from tool0.ur.control_box import UrControlBox
from tool0.ur.messages import Message
from tool0.ur.pacer import Pacer
from tool0.ur.robotiq.gripper import RobotiqGripper
from tool0.ur.robotiq.interface import RobotiqInterface

LONG = 30.0  # [wall s]; only a failing test waits so long


@final
@dataclass(frozen=True)
class ServedGripper:
    """What a test talks to."""

    robot: tool0.Robot
    box: UrControlBox
    gripper: RobotiqGripper
    """Of the event loop's thread: see ``do``."""
    interface: RobotiqInterface
    host: str
    loop: asyncio.AbstractEventLoop
    errors: list[str] = field(default_factory=list)
    """What its box has reported."""

    def do(self, action: Callable[[], Any]) -> Any:
        """Return what an action, maybe a coroutine, returns in the event loop."""

        async def run() -> Any:
            result = action()
            return await result if asyncio.iscoroutine(result) else result

        return asyncio.run_coroutine_threadsafe(run(), self.loop).result(LONG)

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until something holds for the registers."""
        self.do(lambda: self.gripper.wait_until(condition))

    def wait_for_update(self, condition: Callable[[], bool]) -> None:
        """Wait for an update at which something holds."""
        self.do(lambda: self.box.until(condition))

    def sleep(self, duration: float) -> None:
        """Let simulated time pass [s]."""
        self.do(lambda: Pacer(self.box).wait(duration))

    def take(self, message: Message) -> None:
        """Remember what the box reports."""
        if is_error(message):
            self.errors.append(error_text(message))


@contextmanager
def serving_gripper(
    robot: tool0.Robot, folder: Path, *, is_activated: bool = False
) -> Iterator[ServedGripper]:
    """Serve the only gripper of a robot at an address of its own."""
    ready: Future[ServedGripper] = Future()
    stop = asyncio.Event()

    async def serve() -> None:
        async with control_box(robot) as box:
            gripper = box.gripper
            assert gripper is not None
            if is_activated:
                gripper.assume_activated()
            interface = RobotiqInterface(gripper, folder / "gripper")
            host = free_host()
            await interface.start(host, 0)
            loop = asyncio.get_running_loop()
            served = ServedGripper(robot, box, gripper, interface, host, loop)
            box.messages.listeners.add(served.take)
            ready.set_result(served)
            await stop.wait()
            await interface.close()

    def run() -> None:
        try:
            asyncio.run(serve())
        except BaseException as error:
            if ready.done():
                raise
            ready.set_exception(error)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        served = ready.result(LONG)
        try:
            yield served
        finally:
            served.loop.call_soon_threadsafe(stop.set)
    finally:
        thread.join(LONG)
    assert served.errors == [], served.errors
