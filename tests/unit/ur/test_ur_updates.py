"""Every state is shown once and in order, as far as there is time for it."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Iterator, Sequence
from typing import Any

import pytest
from ur_box_rig import control_box

import tool0
from tool0.protocol.state import Snapshot
from tool0.ur.updates import MOST_TIME, Updates

N = 20


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5e", realtime=True) as robot:
        yield robot


async def shown(
    robot: tool0.Robot, duration: float = 0.0
) -> tuple[Sequence[Snapshot], list[tuple[str, float]]]:
    """Let states come together; return them, and what was done at which time [s].

    ``duration`` is how long it takes to send one of them [wall s].
    """
    async with control_box(robot) as box:
        states: list[Snapshot] = []
        while len(states) < N:
            await box.next_update()
            states.append(box.snapshot)
        done: list[tuple[str, float]] = []

        def send() -> None:
            done.append(("sent", box.time))
            end = time.monotonic() + duration
            while time.monotonic() < end:
                pass

        async def wait() -> None:
            await box.next_update()
            done.append(("answered", box.time))

        def look() -> None:
            done.append(("looked", box.time))

        waiting = asyncio.create_task(wait())
        await asyncio.sleep(0)  # it waits
        box.when_shown.add(send)
        box.when_updated.add(look)
        Updates([box]).show(states)  # nobody else has a turn meanwhile
        box.when_shown.discard(send)
        box.when_updated.discard(look)
        await waiting
        return states, done


def test_states_that_come_together_are_sent_before_anybody_acts(
    robot: tool0.Robot,
) -> None:
    states, done = asyncio.run(shown(robot))
    *passed, newest = (state.time for state in states)
    assert done[:-1] == [
        *(("sent", time) for time in passed),
        ("looked", newest),
        ("sent", newest),
    ]
    assert done[-1][1] >= newest


def test_a_process_without_time_leaves_states_out_and_says_so(
    robot: tool0.Robot, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, "tool0.ur.updates"):
        states, done = asyncio.run(shown(robot, duration=MOST_TIME / 4))
    sent: list[Any] = [time for what, time in done if what == "sent"]
    assert sent == sorted(set(sent))
    assert sent[-1] == states[-1].time
    assert 1 < len(sent) <= 6
    (record,) = caplog.records
    assert f"{N - len(sent)} states were left out" in record.getMessage()
