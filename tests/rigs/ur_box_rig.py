"""Control boxes of a robot of a test, in the test's own event loop."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator

from served import serving

import tool0
from tool0.errors import Tool0Error
from tool0.protocol.socket_channel import SocketChannel
from tool0.ur.control_box import UrControlBox, box_states

_numbers = itertools.count(1)


@contextlib.asynccontextmanager
async def control_box(robot: tool0.Robot, arm: str = "") -> AsyncIterator[UrControlBox]:
    """Connect a box with one arm of a robot; the only one, if left out."""
    loop = asyncio.get_running_loop()
    boxes: list[UrControlBox] = []
    refused: list[Tool0Error] = []

    def take() -> None:
        for snapshot in subscription.pending() if boxes else ():
            boxes[0].take(snapshot)

    def in_loop() -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(take)

    name = f"box{next(_numbers)}"
    with serving(robot, name):
        channel = await asyncio.to_thread(SocketChannel, name)
        channel.when_refused = refused.append
        try:
            name = arm or robot.arm.name
            subscription = await asyncio.to_thread(
                channel.follow, box_states([name]), when_published=in_loop
            )
            first = await asyncio.to_thread(subscription.next)
            boxes.append(UrControlBox(channel, name, first))
            yield boxes[0]
        finally:
            await asyncio.to_thread(channel.close)
    assert not refused
