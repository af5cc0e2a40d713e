"""The order in which one connection's messages are carried out."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

import pytest

from tool0.protocol.methods import methods
from tool0.protocol.programs import RunProgram, StopRun
from tool0.protocol.request import Request, method_name
from tool0.protocol.robot import ReadSnapshot
from tool0.protocol.running import EmergencyStop
from tool0.server.budget import RESERVE, Account, Budget
from tool0.server.session import MAX_BACKLOG, MAX_TEXTS, Ident, Session

LONG = 30.0  # [wall s]; only a failing test waits so long


def line(ident: int, method: str, **params: object) -> bytes:
    return json.dumps({"id": ident, "method": method, "params": params}).encode()


class Wire:
    """A transport between a test and a session."""

    is_trusted = True
    files = None

    def __init__(self, account: Account) -> None:
        self.account = account
        self.arriving: asyncio.Queue[bytes | None] = asyncio.Queue()
        self.sent: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.n_read = 0

    def put(self, *texts: bytes | None) -> None:
        for text in texts:
            self.arriving.put_nowait(text)

    async def send(self, texts: Sequence[bytes]) -> None:
        for text in texts:
            self.sent.put_nowait(json.loads(text))

    async def receive(self) -> bytes | None:
        text = await self.arriving.get()
        self.n_read += 1
        return text

    async def close(self) -> None:
        self.put(None)

    def abort(self) -> None:
        self.put(None)


class Peer:
    """A session, and what it has carried out."""

    def __init__(self, account: Account) -> None:
        self.wire = Wire(account)
        self.done: list[str] = []
        self.changed = asyncio.Event()
        self.gates: dict[type[Request[Any]], asyncio.Event] = {}
        """Requests that last until their event."""
        self.session = Session(self.wire, self.take, self.carry_out, self.stop)
        self.serving = asyncio.create_task(self.session.serve())

    def take(self, session: Session, ident: Ident, request: Request[Any]) -> bool:
        return False

    def stop(self, session: Session, ident: Ident, request: Request[Any]) -> None:
        self.note(request)

    async def carry_out(
        self, session: Session, ident: Ident, request: Request[Any]
    ) -> None:
        gate = self.gates.get(type(request))
        self.note(request)
        if gate is not None:
            await gate.wait()

    def note(self, request: Request[Any]) -> None:
        self.done.append(method_name(type(request)))
        self.changed.set()

    async def until(self, condition: Callable[[], bool]) -> None:
        async def wait() -> None:
            while not condition():
                self.changed.clear()
                await self.changed.wait()

        await asyncio.wait_for(wait(), LONG)

    async def end(self) -> None:
        self.wire.put(None)
        for gate in self.gates.values():
            gate.set()
        await asyncio.wait_for(self.serving, LONG)


def ample() -> Account:
    return Budget().account()


def never() -> Account:
    """Return an account that admits nothing: two have used all, and no time passes."""
    budget = Budget(share=0.5, burst=0.0, now=lambda: 0.0)
    budget.account().charge(RESERVE)
    account = budget.account()
    account.charge(2.0 * RESERVE)
    return account


def run(scenario: Callable[[], Awaitable[None]]) -> None:
    async def with_limit() -> None:
        await asyncio.wait_for(scenario(), 2.0 * LONG)

    asyncio.run(with_limit())


def test_a_stop_overtakes_what_may_not_even_be_decoded() -> None:
    async def scenario() -> None:
        peer = Peer(never())
        peer.wire.put(*[line(k, "read_snapshot") for k in range(50)])
        peer.wire.put(b"{broken", line(99, "emergency_stop"))
        await peer.until(lambda: "emergency_stop" in peer.done)
        assert peer.done == ["emergency_stop"]
        peer.serving.cancel()

    run(scenario)


def test_a_stop_of_a_client_that_may_not_work_is_taken_at_once() -> None:
    async def scenario() -> None:
        peer = Peer(never())
        peer.wire.put(line(1, "emergency_stop"))
        await peer.until(lambda: peer.done == ["emergency_stop"])
        assert not peer.session.account.may_go_on
        peer.serving.cancel()

    run(scenario)


def test_a_stop_overtakes_a_full_queue() -> None:
    async def scenario() -> None:
        peer = Peer(ample())
        gate = peer.gates[ReadSnapshot] = asyncio.Event()
        reads = [line(k, "read_snapshot") for k in range(MAX_BACKLOG + 3)]
        peer.wire.put(*reads)
        await peer.until(lambda: bool(peer.done))
        peer.wire.put(line(-1, "emergency_stop"))
        await peer.until(lambda: "emergency_stop" in peer.done)
        assert peer.done == ["read_snapshot", "emergency_stop"]
        gate.set()
        # Some may have been refused: those that were decoded while too many waited.
        await peer.until(lambda: len(peer.done) > MAX_BACKLOG)
        await peer.end()

    run(scenario)


def test_a_flood_is_read_no_further_than_it_is_decoded() -> None:
    async def scenario() -> None:
        peer = Peer(never())
        text = line(1, "read_snapshot", padding="x" * 1000)
        peer.wire.put(*[text] * (2 * MAX_TEXTS // len(text)))
        while peer.wire.n_read < 0.9 * MAX_TEXTS / len(text):
            await asyncio.sleep(0)
        for _ in range(1000):
            await asyncio.sleep(0)
        assert peer.wire.n_read <= MAX_TEXTS / len(text) + 1
        peer.serving.cancel()

    run(scenario)


def test_what_would_undo_a_stop_that_overtakes_it_is_refused() -> None:
    async def scenario() -> None:
        peer = Peer(ample())
        gate = peer.gates[ReadSnapshot] = asyncio.Event()
        peer.wire.put(line(1, "read_snapshot"))
        await peer.until(lambda: bool(peer.done))
        peer.wire.put(
            line(2, "resume_run", arm="left"),
            line(3, "resume_run", arm="right"),
            line(4, "run_program", name="pick"),
            line(5, "stop_run", arm="left"),
        )
        await peer.until(lambda: "stop_run" in peer.done)
        for ident in (2, 4):
            answer = await asyncio.wait_for(peer.wire.sent.get(), LONG)
            assert answer["id"] == ident
            assert "overtook" in answer["error"]["message"]
        gate.set()
        await peer.until(lambda: len(peer.done) >= 3)
        assert peer.done == ["read_snapshot", "stop_run", "resume_run"]
        await peer.end()

    run(scenario)


def test_what_is_not_decoded_and_would_undo_a_stop_is_refused_too() -> None:
    async def scenario() -> None:
        peer = Peer(never())
        peer.wire.put(line(1, "run_program", name="pick"), line(2, "stop_run"))
        await peer.until(lambda: "stop_run" in peer.done)
        answer = await asyncio.wait_for(peer.wire.sent.get(), LONG)
        assert answer["id"] == 1
        assert "overtook" in answer["error"]["message"]
        peer.serving.cancel()

    run(scenario)


def test_a_stop_follows_a_start_in_progress_before_everything_else() -> None:
    async def scenario() -> None:
        peer = Peer(ample())
        gate = peer.gates[RunProgram] = asyncio.Event()
        peer.wire.put(line(1, "run_program", name="pick"))
        await peer.until(lambda: bool(peer.done))
        peer.wire.put(
            line(2, "read_snapshot"),
            line(3, "stop_run"),
            line(4, "emergency_stop"),
        )
        await peer.until(lambda: "emergency_stop" in peer.done)
        assert peer.done == ["run_program", "emergency_stop"]
        gate.set()
        await peer.until(lambda: len(peer.done) >= 4)
        assert peer.done[2:] == ["stop_run", "read_snapshot"]
        await peer.end()

    run(scenario)


@pytest.mark.parametrize("stop", [EmergencyStop, StopRun])
def test_stops_are_urgent(stop: type[Request[Any]]) -> None:
    assert stop.is_urgent


def test_the_contract_has_everything_that_a_stop_revokes() -> None:
    named = {name for request in methods().values() for name in request.revokes}
    assert named
    assert named <= methods().keys()
