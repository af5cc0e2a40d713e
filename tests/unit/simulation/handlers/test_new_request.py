"""A new operation is one declaration and one handler, here, and nothing else.

Python, the Unix socket and the WebSocket of the panel can call it at once.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import pytest
from msgspec import Meta, Struct
from websockets.sync.client import connect as open_websocket

import tool0
from tool0.errors import RequestError
from tool0.panel.address import open_endpoint
from tool0.panel.server import panel_service
from tool0.protocol import codec
from tool0.protocol.address import Claim
from tool0.protocol.request import Request
from tool0.server.server import Server, UnixSocketService
from tool0.simulation.handlers.table import handles
from tool0.simulation.simulation import Simulation


class JointTravel(Struct, frozen=True):
    """How far a joint is from a position."""

    joint: str
    distance: float
    """[rad | m]"""


class MeasureTravel(Request[JointTravel], frozen=True):
    """The distance of a joint from a position."""

    joint: str
    position: Annotated[float, Meta(ge=-10.0, le=10.0)] = 0.0
    """[rad | m]"""


@handles(MeasureTravel, in_tick=True, publishes=False)
def _measure(simulation: Simulation, request: MeasureTravel) -> JointTravel:
    core = simulation.core
    at = core.state.position[core.hardware.index[request.joint]]
    return JointTravel(joint=request.joint, distance=abs(at - request.position))


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tool0.Robot]:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with tool0.bringup(realtime=False) as robot:
        yield robot


REQUEST = MeasureTravel(joint="elbow_joint", position=1.0)
TOO_FAR = MeasureTravel(joint="elbow_joint", position=11.0)


def test_python_socket_and_websocket_call_it(robot: tool0.Robot) -> None:
    endpoint = open_endpoint(port=0, token="secret")
    backend, page = panel_service(robot, endpoint)
    with Server(backend, [UnixSocketService(Claim("new")), page], "new"):
        with tool0.connect("new") as remote:
            for caller in (robot, remote):
                travel = caller.channel.call(REQUEST)
                assert travel == JointTravel("elbow_joint", pytest.approx(0.5708))
                with pytest.raises(RequestError):
                    caller.channel.call(TOO_FAR)
        address = endpoint.url.replace("http", "ws").replace("/?", "/ws?")
        with open_websocket(address) as socket:
            assert json.loads(socket.recv())["type"] == "hello"
            socket.send(codec.encode_request(1, REQUEST))
            reply = json.loads(socket.recv())
            assert reply["result"]["distance"] == pytest.approx(0.5708)
            socket.send(codec.encode_request(2, TOO_FAR))
            assert json.loads(socket.recv())["error"]["type"] == "RequestError"
