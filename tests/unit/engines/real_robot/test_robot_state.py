"""One state for each period, whatever arrives of the packages."""

from __future__ import annotations

from collections import deque
from typing import Any, cast

import pytest

from tool0.devices.rtde_client import RtdeClient
from tool0.engines.real_robot.robot_state import StateReader
from tool0.errors import TransportError

PERIOD = 0.002
COLUMNS = {
    "timestamp": slice(0, 1),
    "actual_q": slice(1, 7),
    "actual_qd": slice(7, 13),
    "target_moment": slice(13, 19),
    "output_int_register_24": slice(19, 20),
}


class Client:
    """Hands out packages as they were put in."""

    rate = 500.0
    columns = COLUMNS

    def __init__(self) -> None:
        self.batches: deque[list[Any] | None] = deque()

    def receive(self, timeout: float) -> list[Any]:
        batch = self.batches.popleft() if self.batches else []
        if batch is None:
            raise TransportError("gone")
        return batch


def package(period: int, q: float = 0.0, step: int = 0) -> tuple[float, ...]:
    return (100.0 + period * PERIOD, *[q] * 6, *[0.5] * 6, *[1.0] * 6, step)


def reader() -> tuple[StateReader, Client]:
    client = Client()
    return StateReader(cast(RtdeClient, client), package(0)), client


def test_each_package_is_a_period_in_order() -> None:
    states, client = reader()
    client.batches.append([package(1, 0.1), package(2, 0.2)])
    assert [states.next().tick, states.next().tick] == [1, 2]
    assert states.state.positions == (0.2,) * 6
    assert states.missing == 0


def test_what_is_missing_is_interpolated_and_counted() -> None:
    states, client = reader()
    client.batches.append([package(1, 0.0), package(4, 0.3)])
    found = [states.next() for _ in range(4)]
    assert [state.tick for state in found] == [1, 2, 3, 4]
    assert [state.positions[0] for state in found] == pytest.approx([0, 0.1, 0.2, 0.3])
    assert states.missing == 2


def test_a_lost_link_repeats_the_last_state_at_rest() -> None:
    states, client = reader()
    client.batches += [[package(1, 0.1)], None]
    assert states.next().tick == 1
    repeated = states.next()
    assert not states.is_connected
    assert (repeated.tick, repeated.positions[0], repeated.velocities[0]) == (
        2,
        0.1,
        0.0,
    )
    states.reconnect(cast(RtdeClient, client))
    client.batches.append([package(2, 0.1), package(3, 0.1)])
    assert states.next().tick == 3
    assert states.is_connected


def test_time_goes_on_after_the_robot_was_restarted() -> None:
    states, client = reader()
    client.batches.append([package(500), package(-40_000)])
    assert [states.next().tick for _ in range(501)][-1] == 501


def test_the_programs_period_is_the_most_advanced_that_it_showed() -> None:
    states, client = reader()
    client.batches.append(
        [package(1, step=11), package(2, step=11), package(3, step=13)]
    )
    assert [states.next().step for _ in range(3)] == [11, 12, 13]


def test_another_run_of_the_program_counts_anew() -> None:
    states, client = reader()
    client.batches.append(
        [package(1, step=500), package(2, step=1), package(3, step=2)]
    )
    assert [states.next().step for _ in range(3)] == [500, 1, 2]
