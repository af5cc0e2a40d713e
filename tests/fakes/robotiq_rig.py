"""A robot whose gripper's interfaces are served by an event loop of this process."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, final

from msgspec import UnsetType
from served import serving
from ur_address import free_host

import tool0
from tool0.api.connect import SocketChannel
from tool0.description.parts import find_grippers
from tool0.errors import Tool0Error
from tool0.hardware.control_box import ControlBoxState
from tool0.interfaces.ur.robotiq.gripper import RobotiqGripper
from tool0.interfaces.ur.robotiq.interface import RobotiqInterface
from tool0.requests.table import Request
from tool0.requests.updates import SubscribeUpdates, UpdateMessage

R = TypeVar("R")
_numbers = itertools.count(1)
LONG = 30.0  # [wall s]; only a failing test waits so long


@final
class Link:
    """A connection to a bring-up, as a control box has one."""

    def __init__(self, channel: SocketChannel) -> None:
        self._channel = channel
        self._loop = asyncio.get_running_loop()
        self._first = asyncio.Event()
        self.when_updated: set[Callable[[], None]] = set()
        self.errors: list[Tool0Error] = []
        self.update: UpdateMessage
        self.state: ControlBoxState
        self.joint_names: tuple[str, ...] = ()
        channel.when_updated = lambda update: self._in_loop(self._take, update)

    def _in_loop(self, callback: Callable[[Any], None], argument: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(callback, argument)

    def _take(self, update: UpdateMessage) -> None:
        self.update = update
        if not isinstance(update.joint_names, UnsetType):
            self.joint_names = update.joint_names
        if not isinstance(update.control_boxes, UnsetType):
            (self.state,) = update.control_boxes
        self._first.set()
        for callback in tuple(self.when_updated):
            callback()

    @property
    def time(self) -> float:
        return self.update.time

    async def subscribe(self) -> None:
        await asyncio.to_thread(self._channel.call, SubscribeUpdates())
        await self._first.wait()

    async def call(self, request: Request[R]) -> R:
        future: asyncio.Future[R] = self._loop.create_future()

        def finish(outcome: Callable[[], R]) -> None:
            if not future.done():
                try:
                    future.set_result(outcome())
                except Tool0Error as error:
                    future.set_exception(error)

        self._channel.submit(
            request,
            lambda outcome: self._in_loop(finish, outcome),
        )
        return await future

    async def until(self, condition: Callable[[], bool]) -> None:
        """Wait for an update at which something holds."""
        reached = asyncio.Event()

        def look() -> None:
            if condition():
                reached.set()

        self.when_updated.add(look)
        await reached.wait()
        self.when_updated.discard(look)

    async def sleep(self, duration: float) -> None:
        end = self.time + duration
        await self.until(lambda: self.time >= end)

    def report(self, error: Tool0Error) -> None:
        self.errors.append(error)


@final
@dataclass(frozen=True)
class ServedGripper:
    """What a test talks to."""

    robot: tool0.Robot
    link: Link
    gripper: RobotiqGripper
    """Of the event loop's thread: see ``do``."""
    interface: RobotiqInterface
    host: str
    loop: asyncio.AbstractEventLoop

    def do(self, action: Callable[[], Any]) -> Any:
        """Return what an action, maybe a coroutine, returns in the event loop."""

        async def run() -> Any:
            result = action()
            return await result if asyncio.iscoroutine(result) else result

        return asyncio.run_coroutine_threadsafe(run(), self.loop).result(LONG)

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until something holds for the registers."""
        self.do(lambda: self.gripper.wait_until(condition))


@contextmanager
def serving_gripper(
    robot: tool0.Robot, folder: Path, *, is_activated: bool = False
) -> Iterator[ServedGripper]:
    """Serve the only gripper of a robot at an address of its own."""
    ready: Future[ServedGripper] = Future()
    name = f"gripper-{next(_numbers)}"
    with serving(robot, name):
        channel = SocketChannel(name)
        stop = asyncio.Event()

        async def serve() -> None:
            link = Link(channel)
            await link.subscribe()
            ((part, geometry),) = find_grippers(robot.description.model).items()
            gripper = RobotiqGripper(
                link,
                part,
                geometry,
                link.joint_names.index(geometry.joint),
                is_activated=is_activated,
            )
            interface = RobotiqInterface(gripper, folder / "gripper")
            host = free_host()
            await interface.start(host, 0)
            loop = asyncio.get_running_loop()
            ready.set_result(ServedGripper(robot, link, gripper, interface, host, loop))
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
            channel.close()
