import socket
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tool0.engines.gazebo.connection import (
    VERSION,
    BridgeConnection,
    BridgeListener,
    RequestKind,
    pack_floats,
    pack_text,
)
from tool0.errors import EngineError, EngineUnavailableError

HELLO = struct.pack("=I", VERSION) + b"11.1.0"
Call = Callable[[bytes | None], socket.socket]


@pytest.fixture
def listener(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[BridgeListener]:
    folder = tmp_path / ("far" * 40)  # longer than a socket's path may be
    folder.mkdir()
    listener = BridgeListener(folder / "bridge")
    monkeypatch.chdir(folder)  # as gzserver
    yield listener
    listener.close()
    assert list(folder.iterdir()) == []


@pytest.fixture
def call(listener: BridgeListener) -> Iterator[Call]:
    """Call the listener as a bridge that says so and so, or hangs up."""
    callers = []

    def call(hello: bytes | None) -> socket.socket:
        caller = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        callers.append(caller)
        caller.connect("bridge")
        if hello is None:
            caller.shutdown(socket.SHUT_RDWR)
        else:
            caller.send(hello)
        return caller

    yield call
    for caller in callers:
        caller.close()


@pytest.fixture
def ends() -> Iterator[tuple[socket.socket, BridgeConnection, list[str]]]:
    """Return the bridge's end, ours, and what the server was lost for."""
    losses: list[str] = []

    def on_lost(why: str) -> EngineUnavailableError:
        losses.append(why)
        return EngineUnavailableError(why)

    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    connection = BridgeConnection(ours, on_lost)
    yield theirs, connection, losses
    theirs.close()
    connection.close()


def nothing() -> None:
    """Find nothing wrong with the server."""


def test_greets_a_bridge_of_its_version(listener: BridgeListener, call: Call) -> None:
    bridge = call(HELLO)
    listener.accept(0.002, nothing, timeout=30.0).close()
    assert struct.unpack("=Id", bridge.recv(100)) == (VERSION, 0.002)


@pytest.mark.parametrize(
    ("hello", "named"),
    [
        (struct.pack("=I", VERSION + 1), str(VERSION + 1)),
        (struct.pack("=I", VERSION + 1), "`tool0 gazebo install`"),
        (b"?", ""),
        (None, ""),
    ],
)
def test_refuses_a_wrong_bridge(
    hello: bytes | None, named: str, listener: BridgeListener, call: Call
) -> None:
    bridge = call(hello)
    with pytest.raises(EngineUnavailableError) as error:
        listener.accept(0.001, nothing, timeout=30.0)
    assert named in str(error.value)
    assert bridge.recv(100) == b""  # hung up


def test_does_not_wait_for_ever(listener: BridgeListener) -> None:
    with pytest.raises(EngineUnavailableError) as error:
        listener.accept(0.001, nothing, timeout=0.05)
    assert "0.05 s" in str(error.value)


def test_does_not_wait_for_a_server_that_has_ended(listener: BridgeListener) -> None:
    def ended() -> None:
        raise gone

    gone = EngineUnavailableError("it has ended")
    with pytest.raises(EngineUnavailableError) as error:
        listener.accept(0.001, ended, timeout=60.0)
    assert error.value is gone


def test_asks_and_takes_the_answer(
    ends: tuple[socket.socket, BridgeConnection, list[str]],
) -> None:
    bridge, connection, _ = ends
    bridge.send(struct.pack("=Id", 0, 4.25))
    answer = connection.request(
        RequestKind.BIND, pack_text("arm"), pack_floats([1.0, 2.0])
    )
    assert struct.unpack("=d", answer) == (4.25,)
    assert bridge.recv(100) == struct.pack("=I4s2d", RequestKind.BIND, b"arm", 1.0, 2.0)


def test_a_refusal_is_no_loss(
    ends: tuple[socket.socket, BridgeConnection, list[str]],
) -> None:
    bridge, connection, losses = ends
    bridge.send(struct.pack("=I", 1) + b"no such model")
    with pytest.raises(EngineError) as error:
        connection.request(RequestKind.DELETE, pack_text("box"))
    assert type(error.value) is EngineError
    assert str(error.value) == "no such model"
    assert losses == []


def test_a_loss_is_told_once_and_remembered(
    ends: tuple[socket.socket, BridgeConnection, list[str]],
) -> None:
    bridge, connection, losses = ends
    bridge.close()
    errors = []
    for _ in range(2):
        with pytest.raises(EngineUnavailableError) as error:
            connection.request(RequestKind.OBJECTS)
        errors.append(error.value)
        with pytest.raises(EngineUnavailableError) as error:
            connection.request(RequestKind.DELETE, pack_text("box"), timeout=12.0)
        errors.append(error.value)
    assert len(losses) == len(set(errors)) == 1


@pytest.mark.slow
def test_a_bridge_that_is_silent_is_lost(
    ends: tuple[socket.socket, BridgeConnection, list[str]],
) -> None:
    bridge, connection, losses = ends
    with pytest.raises(EngineUnavailableError):
        connection.request(RequestKind.OBJECTS)
    (loss,) = losses
    assert "1.5 s" in loss
    bridge.settimeout(30.0)
    assert bridge.recv(100) != b""
    assert bridge.recv(100) == b""  # hung up


def test_a_name_that_would_end_early_is_refused() -> None:
    with pytest.raises(EngineError):
        pack_text("a\0b")
