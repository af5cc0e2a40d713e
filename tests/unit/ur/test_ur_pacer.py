"""Intervals of a program follow each other, as far as the program goes on at once."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import cast

import pytest

from tool0.ur.control_box import UrControlBox
from tool0.ur.pacer import AT_ONCE, CATCH_UP, Pacer


class Box:
    """A control box whose updates come late: several periods at once."""

    def __init__(self, update: float) -> None:
        self.time = 0.0
        self.state = SimpleNamespace(speed_scaling=1.0)
        self.update = update
        """Between two updates that the process sees [s]."""

    async def next_update(self) -> None:
        self.time += self.update


def pacer(update: float) -> tuple[Box, Pacer]:
    box = Box(update)
    return box, Pacer(cast(UrControlBox, box))


@pytest.mark.parametrize("update", [0.008, 0.04, 0.8 * CATCH_UP])
def test_steps_take_as_long_as_they_should_in_a_process_that_is_late(
    update: float,
) -> None:
    box, steps = pacer(update)

    async def run() -> None:
        for _ in range(100):
            await steps.wait(0.008)

    asyncio.run(run())
    assert box.time == pytest.approx(0.8, abs=update + 1e-9)


@pytest.mark.parametrize("elsewhere", [1.5 * AT_ONCE, 0.09, 1.0])
def test_what_a_program_waits_for_elsewhere_is_no_part_of_a_step(
    elsewhere: float,
) -> None:
    box, steps = pacer(0.002)

    async def run() -> float:
        await steps.wait(0.1)
        box.time += elsewhere  # as for the end of a motion
        start = box.time
        await steps.wait(0.15)
        return box.time - start

    assert asyncio.run(run()) == pytest.approx(0.15, abs=0.0021)
