"""What clients may use together, in simulated wall time."""

from __future__ import annotations

import asyncio
import itertools
import time

import pytest
from manual_clock import ManualClock

from tool0.server.budget import MAX_CHARGE, RESERVE, SLICE, Account, Budget


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


def exhausted(clock: ManualClock, n_clients: int) -> tuple[Budget, list[Account]]:
    """Return a budget without a burst, and clients that have used what they may."""
    budget = Budget(share=0.5, burst=0.0, now=clock)
    clients = [budget.account() for _ in range(n_clients)]
    for client in clients:
        client.charge(RESERVE)
    return budget, clients


def test_a_client_alone_never_waits(clock: ManualClock) -> None:
    _, (client,) = exhausted(clock, 1)
    for _ in range(1000):
        client.charge(MAX_CHARGE)
    assert client.may_go_on


def test_nobody_waits_while_there_is_a_burst(clock: ManualClock) -> None:
    budget = Budget(share=0.5, burst=1.0, now=clock)
    busy, other = budget.account(), budget.account()
    for _ in range(20):
        busy.charge(MAX_CHARGE)
        other.charge(MAX_CHARGE)
    assert busy.may_go_on
    assert busy.has_spare


def test_who_has_used_more_waits_and_who_has_not_goes_on(clock: ManualClock) -> None:
    budget, (*flooding, _) = exhausted(clock, 5)
    newcomer = budget.account()
    newcomer.charge(RESERVE / 2)
    assert newcomer.may_go_on
    assert not any(client.may_go_on for client in flooding)
    assert not newcomer.has_spare


def test_all_parts_together_are_the_share(clock: ManualClock) -> None:
    _, clients = exhausted(clock, 5)
    piece, used = 1e-3, 0.0
    for _ in range(10_000):
        clock.time += 1e-3
        for client in clients:
            if client.may_go_on:
                client.charge(piece)
                used += piece
    assert used / 10.0 == pytest.approx(0.5, rel=0.05)


def test_a_part_grows_when_others_leave(clock: ManualClock) -> None:
    budget, (first, *_) = exhausted(clock, 5)
    assert budget.part == pytest.approx(0.1)
    clock.time += 0.09
    first.charge(1e-6)
    budget.account().charge(1e-6)
    clock.time += 0.05
    assert budget.part == pytest.approx(0.25)


def test_a_long_plan_silences_its_client_for_a_short_time_only(
    clock: ManualClock,
) -> None:
    budget, (planning, _) = exhausted(clock, 2)
    planning.charge(5.0)
    clock.time += 2.0 * MAX_CHARGE / budget.part
    assert planning.may_go_on


def test_nobody_owes_for_the_flood_of_others(clock: ManualClock) -> None:
    budget = Budget(share=0.5, burst=1.0, now=clock)
    for client in [budget.account() for _ in range(20)]:
        for _ in range(100):
            client.charge(MAX_CHARGE)
    clock.time += 2.0 * RESERVE / budget.share
    assert budget.account().has_spare


def burn(seconds: float) -> None:
    """Use processor time."""
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def test_the_event_loop_looks_at_its_sockets_between_slices() -> None:
    """Many clients with work: a callback that is due waits for one slice of one."""

    async def order() -> list[str]:
        budget, found = Budget(), []
        loop = asyncio.get_running_loop()

        async def work(name: str) -> None:
            account = budget.account()
            for _ in range(3):
                await account.admit()
                with account.working():
                    burn(2.0 * SLICE)
                    found.append(name)
                    loop.call_soon(found.append, "sockets")

        await asyncio.gather(*(work(name) for name in "abcde"))
        return found

    found = asyncio.run(order())
    assert [name for name in found if name != "sockets"].count("a") == 3
    for before, after in itertools.pairwise(found):
        assert "sockets" in (before, after)


def test_a_client_that_leaves_while_it_waits_delays_nobody() -> None:
    async def finish() -> bool:
        budget = Budget()
        leaving, staying = budget.account(), budget.account()
        with leaving.working():
            burn(2.0 * SLICE)
        task = asyncio.create_task(leaving.admit())
        await asyncio.sleep(0)
        task.cancel()
        await asyncio.wait_for(staying.admit(), 30.0)
        return staying.may_go_on

    assert asyncio.run(finish())
