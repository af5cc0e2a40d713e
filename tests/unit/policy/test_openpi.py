"""Policies behind openpi's websocket, with a server on this machine.

The messages are those that openpi_client 0.1.2 packs and unpacks: an array is a map of
``__ndarray__``, ``data``, ``dtype`` and ``shape``, whose keys are bytes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import msgspec
import numpy as np
import pytest
from raises_naming import raises_naming
from websockets.sync.server import ServerConnection, serve

from tool0.errors import ConfigError, PolicyError, TransportError
from tool0.policy import EpisodeRun, RunOptions, evaluate

Answer = Callable[[dict[str, Any]], str | dict[str, Any]]
STEPS = RunOptions(max_steps=8)


def array(values: Any) -> dict[bytes, Any]:
    found = np.asarray(values, np.float32)
    return {
        b"__ndarray__": True,
        b"data": found.tobytes(),
        b"dtype": found.dtype.str,
        b"shape": found.shape,
    }


@contextmanager
def served(answer: Answer) -> Iterator[str]:
    """Serve answers to requests; yield the address."""

    def talk(socket: ServerConnection) -> None:
        socket.send(msgspec.msgpack.encode({"rate": 20}))
        for message in socket:
            found = answer(msgspec.msgpack.decode(message))
            socket.send(found if isinstance(found, str) else encode(found))

    encode = msgspec.msgpack.encode
    with serve(talk, "127.0.0.1", 0, compression=None, max_size=None) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        finally:
            server.shutdown()
            thread.join()


def test_actions_of_a_server_are_executed() -> None:
    requests: list[dict[str, Any]] = []

    def up(request: dict[str, Any]) -> dict[str, Any]:
        requests.append(request)
        return {"actions": array(np.tile([0.0, 0.0, 0.5, 0.0, 1.0], (4, 1)))}

    found: list[EpisodeRun] = []
    with served(up) as address:
        evaluate(
            address,
            "Reach",
            [0],
            options={"observation": "image", "image_size": (32, 24)},
            run=STEPS,
            instruction="Go up.",
            when_ended=found.append,
        )
    assert len(requests) == 2  # for eight actions
    assert requests[0]["prompt"] == "Go up."
    image = requests[0]["observation/image"]
    assert (image[b"shape"], image[b"dtype"]) == ([24, 32, 3], "|u1")
    assert len(image[b"data"]) == 24 * 32 * 3
    assert found[0].episode is not None
    height = found[0].episode.observations["state"][:, 14]  # tcp.z
    assert height[-1] > height[0] + 0.04


def test_keys_say_what_a_server_gets() -> None:
    seen: dict[str, Any] = {}

    def note(request: dict[str, Any]) -> dict[str, Any]:
        seen.update(request)
        return {"actions": array([0.0] * 5)}

    keys = {"joints": "elbow_joint.position,wrist_1_joint.position", "text": "prompt"}
    with served(note) as address:
        evaluate(address, "Reach", [0], keys=keys, run=RunOptions(max_steps=1))
        with raises_naming(ConfigError, "elbow_joint.positon", "did you mean"):
            wrong = {"joints": "elbow_joint.positon"}
            evaluate(address, "Reach", [0], keys=wrong, run=STEPS)
    assert seen["text"] == "Move the tool to the goal."
    assert seen["joints"][b"shape"] == [2]
    elbow, _ = np.frombuffer(seen["joints"][b"data"], np.float32)
    assert abs(elbow) > 0.5


@pytest.mark.parametrize(
    ("answer", "shown"),
    [
        ("Traceback …\nValueError: no image", "ValueError: no image"),
        ({"action": [0.0]}, "answers without 'actions'"),
        ({"actions": array(np.zeros((3, 2)))}, "shape (3, 2)"),
        ({"actions": {**array([0.0] * 5), b"dtype": "|O"}}, "no msgpack of arrays"),
        ({"actions": {**array([0.0] * 5), b"shape": (7,)}}, "no msgpack of arrays"),
    ],
)
def test_what_a_server_does_wrong_is_said(answer: Any, shown: str) -> None:
    with served(lambda request: answer) as address, raises_naming(PolicyError, shown):
        evaluate(address, "Reach", [0], run=STEPS)


def test_without_a_server_the_address_is_named() -> None:
    with served(lambda request: "") as address:
        pass
    with raises_naming(TransportError, "no policy server answers", address):
        evaluate(address, "Reach", [0])
    with raises_naming(ConfigError, "ws://["):
        evaluate("ws://[", "Reach", [0])
