import socket
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from tool0.description.transform import Pose, pose_matrix
from tool0.engines.gazebo.connection import (
    VERSION,
    Connection,
    Kind,
    Listener,
    numbers,
    quat_wxyz,
    text,
)
from tool0.errors import EngineError, EngineUnavailableError

HELLO = struct.pack("=I", VERSION) + b"11.1.0"
Call = Callable[[bytes | None], socket.socket]


@pytest.fixture
def listener(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Listener]:
    folder = tmp_path / ("far" * 40)  # longer than a socket's path may be
    folder.mkdir()
    listener = Listener(folder / "bridge")
    monkeypatch.chdir(folder)  # as gzserver
    yield listener
    listener.close()
    assert list(folder.iterdir()) == []


@pytest.fixture
def call(listener: Listener) -> Iterator[Call]:
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
def ends() -> Iterator[tuple[socket.socket, Connection, list[str]]]:
    """Return the bridge's end, ours, and what the server was lost for."""
    losses: list[str] = []

    def when_lost(why: str) -> EngineUnavailableError:
        losses.append(why)
        return EngineUnavailableError(f"{why}, which is sad")

    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    connection = Connection(ours, when_lost)
    yield theirs, connection, losses
    theirs.close()
    connection.close()


def nothing() -> None:
    """Find nothing wrong with the server."""


def test_greets_a_bridge_of_its_version(listener: Listener, call: Call) -> None:
    bridge = call(HELLO)
    peer, version = listener.accept(0.002, nothing, timeout=1.0)
    peer.close()
    assert version == "11.1.0"
    assert struct.unpack("=Id", bridge.recv(100)) == (VERSION, 0.002)


@pytest.mark.parametrize(
    ("hello", "message"),
    [
        (struct.pack("=I", VERSION + 1), f"speaks version {VERSION + 1}, this tool0"),
        (struct.pack("=I", VERSION + 1), "run `tool0 gazebo install`"),
        (b"?", "does not introduce itself"),
        (None, "does not introduce itself"),
    ],
)
def test_refuses_a_wrong_bridge(
    hello: bytes | None, message: str, listener: Listener, call: Call
) -> None:
    bridge = call(hello)
    with pytest.raises(EngineUnavailableError, match=message):
        listener.accept(0.001, nothing, timeout=1.0)
    assert bridge.recv(100) == b""  # hung up


def test_does_not_wait_for_ever(listener: Listener) -> None:
    with pytest.raises(EngineUnavailableError, match=r"within 0\.05 s"):
        listener.accept(0.001, nothing, timeout=0.05)


def test_does_not_wait_for_a_server_that_has_ended(listener: Listener) -> None:
    def ended() -> None:
        raise EngineUnavailableError("it has ended")

    with pytest.raises(EngineUnavailableError, match="it has ended"):
        listener.accept(0.001, ended, timeout=60.0)


def test_asks_and_takes_the_answer(
    ends: tuple[socket.socket, Connection, list[str]],
) -> None:
    bridge, connection, _ = ends
    bridge.send(struct.pack("=Id", 0, 4.25))
    answer = connection.ask(Kind.BIND, text("arm"), numbers([1.0, 2.0]))
    assert struct.unpack("=d", answer) == (4.25,)
    assert bridge.recv(100) == struct.pack("=I4s2d", Kind.BIND, b"arm", 1.0, 2.0)


def test_a_refusal_is_no_loss(
    ends: tuple[socket.socket, Connection, list[str]],
) -> None:
    bridge, connection, losses = ends
    bridge.send(struct.pack("=I", 1) + b"no such model")
    with pytest.raises(EngineError, match="no such model") as caught:
        connection.delete("box")
    assert not isinstance(caught.value, EngineUnavailableError)
    assert losses == []


def test_a_loss_is_told_once_and_remembered(
    ends: tuple[socket.socket, Connection, list[str]],
) -> None:
    bridge, connection, losses = ends
    bridge.close()
    for _ in range(2):
        with pytest.raises(EngineUnavailableError, match="gone, which is sad"):
            connection.ask(Kind.OBJECTS)
        with pytest.raises(EngineUnavailableError, match="gone, which is sad"):
            connection.delete("box")
    assert losses == ["gzserver is gone"]


@pytest.mark.slow
def test_a_bridge_that_is_silent_is_lost(
    ends: tuple[socket.socket, Connection, list[str]],
) -> None:
    bridge, connection, losses = ends
    with pytest.raises(EngineUnavailableError, match=r"not answer within 1\.5 s"):
        connection.ask(Kind.OBJECTS)
    assert losses == ["gzserver does not answer within 1.5 s"]
    bridge.settimeout(1.0)
    assert bridge.recv(100) != b""
    assert bridge.recv(100) == b""  # hung up


def test_a_name_that_would_end_early_is_refused() -> None:
    with pytest.raises(EngineError, match="zero byte"):
        text("a\0b")


@pytest.mark.parametrize("seed", range(20))
def test_quaternions_turn_as_their_matrices_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    # Half turns, too: there the largest component is another one each time.
    rpy = np.pi * rng.integers(-2, 3, 3) / 2 if seed % 2 else rng.uniform(-4, 4, 3)
    T = pose_matrix(Pose(rpy=(rpy[0], rpy[1], rpy[2])))
    w, *v = quat_wxyz(T)
    assert np.hypot(w, np.linalg.norm(v)) == pytest.approx(1.0)
    p = rng.normal(size=3)
    turned = p + 2.0 * np.cross(v, np.cross(v, p) + w * p)
    np.testing.assert_allclose(turned, T[:3, :3] @ p, atol=1e-12)
