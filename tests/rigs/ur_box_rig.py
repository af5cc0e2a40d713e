"""Control boxes of a robot of a test, in the test's own event loop."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator

from served import serving

import tool0
from tool0.api.connect import SocketChannel
from tool0.errors import Tool0Error
from tool0.protocol.updates import SubscribeUpdates, UpdateMessage
from tool0.ur.control_box import UrControlBox

_numbers = itertools.count(1)


@contextlib.asynccontextmanager
async def control_box(robot: tool0.Robot, arm: str = "") -> AsyncIterator[UrControlBox]:
    """Connect a box with one arm of a robot; the only one, if left out."""
    loop = asyncio.get_running_loop()
    first: asyncio.Future[UpdateMessage] = loop.create_future()
    boxes: list[UrControlBox] = []
    refused: list[Tool0Error] = []

    def take(update: UpdateMessage) -> None:
        if not first.done():
            first.set_result(update)
        for box in boxes:
            box.take(update)

    def in_loop(update: UpdateMessage) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(take, update)

    name = f"box{next(_numbers)}"
    with serving(robot, name):
        channel = await asyncio.to_thread(SocketChannel, name)
        channel.when_updated = in_loop
        channel.when_refused = refused.append
        try:
            name = arm or robot.arm.name
            await asyncio.to_thread(channel.call, SubscribeUpdates(arms=(name,)))
            boxes.append(UrControlBox(channel, name, await first))
            yield boxes[0]
        finally:
            await asyncio.to_thread(channel.close)
    assert not refused
