"""What a backend does not offer is refused before anything else, on every path."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import pytest
from lacking import Lacking
from served import use_folder

import tool0
from tool0.errors import ControlError, Tool0Error
from tool0.protocol.address import Claim
from tool0.protocol.arm_motion import SpeedTool
from tool0.protocol.backend import missing_methods
from tool0.protocol.channel import LocalChannel, backend_of
from tool0.protocol.motion import SteerJoints
from tool0.protocol.poses import GoToPose
from tool0.protocol.request import Request, method_name
from tool0.protocol.running import EmergencyStop, Pause
from tool0.protocol.socket_channel import SocketChannel
from tool0.server.server import Server, UnixSocketService

LONG = 30.0  # [wall s]; only a failing test waits so long
MOTIONS: Final = (
    GoToPose(name="home"),
    SteerJoints(controller="arm_controller", positions={}),
    SpeedTool(twist=(0.0,) * 6),
    EmergencyStop(engaged=True),
)
REASON: Final = "this robot stands still"


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(gripper=None, realtime=False) as robot:
        yield robot


@pytest.fixture
def still(robot: tool0.Robot) -> Lacking:
    return Lacking(backend_of(robot.channel), {type(item) for item in MOTIONS}, REASON)


def refusal(request: Request[Any]) -> str:
    return f"'{method_name(type(request))}' is not offered: {REASON}"


@pytest.mark.parametrize("request_", MOTIONS, ids=lambda item: type(item).__name__)
def test_in_this_process(still: Lacking, request_: Request[Any]) -> None:
    with pytest.raises(ControlError, match=refusal(request_)):
        LocalChannel(still).call(request_)
    assert still.used == []


def test_on_a_connection_with_and_without_a_reply(
    still: Lacking, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_folder(monkeypatch, tmp_path)
    refused: queue.Queue[Tool0Error] = queue.Queue()
    with Server(still, [UnixSocketService(Claim("tool0"))], "tool0"):
        channel = SocketChannel("tool0")
        channel.when_refused = refused.put
        for request in MOTIONS:
            with pytest.raises(ControlError, match=refusal(request)):
                channel.call(request)
            channel.post(request)
            assert str(refused.get(timeout=LONG)) == refusal(request)
        assert still.used == []
        channel.call(Pause())
        assert [type(item) for item in still.used] == [Pause, Pause]
        channel.close()


def test_every_missing_method_is_named_with_its_reason(still: Lacking) -> None:
    found = missing_methods(still)
    assert found["go_to_pose"] == REASON
    assert "tool0 replay" in found["seek_replay"]
    assert not {"pause", "move_joints", "subscribe_view", "view_shown"} & found.keys()
