from __future__ import annotations

import json
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Compound, Cylinder
from tool0.description.transform import Pose
from tool0.errors import (
    ClaimError,
    ConfigError,
    DivergenceError,
    GoalRejectedError,
    RequestError,
    Tool0Error,
    TransportError,
)
from tool0.protocol import codec
from tool0.protocol.goals import GoalResult, GoalStatus, GripperResult, Result
from tool0.protocol.motion import MoveJoints
from tool0.protocol.objects import (
    AddObject,
    BoxShape,
    ObjectInfo,
    info_of,
    object_of,
    shape_of,
)
from tool0.protocol.request import Request, checked
from tool0.protocol.robot import ReadSnapshot
from tool0.protocol.running import EmergencyStop, Step
from tool0.protocol.state_message import (
    SNAPSHOT_FIELDS,
    StateMask,
    snapshot_of,
    state_message,
)
from tool0.protocol.trajectories import FollowTrajectory, TrajectoryPoint

MUG = Compound(
    parts=(
        (Cylinder(radius=0.04, length=0.1), Pose()),
        (Box(size=(0.03, 0.01, 0.06)), Pose(xyz=(0.055, 0.0, 0.0), rpy=(0.1, 0, 0))),
    )
)


def test_an_object_of_several_shapes_arrives_as_it_was_sent() -> None:
    mug = SceneObject(name="mug", geometry=MUG, mass=0.3)
    text = msgspec.json.encode(info_of(mug))
    assert object_of(msgspec.json.decode(text, type=ObjectInfo)) == mug


@pytest.mark.parametrize(
    "request_",
    [
        Step(ticks=5),
        EmergencyStop(engaged=False),
        MoveJoints(positions={"elbow_joint": 1.0}, speed=0.1),
        FollowTrajectory(
            controller="arm",
            points=(TrajectoryPoint([1.0, 2.0], time_from_start=0.5),),
            path_tolerance={"a": 0.1},
        ),
        AddObject(name="cube", shape=BoxShape(size=(0.1, 0.1, 0.1)), mass=1.0),
        AddObject(name="mug", shape=shape_of(MUG), mass=1.0),
    ],
)
def test_a_request_arrives_as_it_was_sent(request_: Request[Any]) -> None:
    assert codec.decode_request(codec.encode_request(3, request_)) == (3, request_)


@given(st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
def test_any_bytes_are_a_request_or_a_readable_refusal(text: bytes) -> None:
    try:
        codec.decode_request(text)
    except codec.RequestReadError as error:
        answer = json.loads(codec.encode_error(error.ident, error.error))
        assert answer["error"]["type"] in ("TransportError", "RequestError")


BAD: list[tuple[object, int | str | None, type[Tool0Error], str]] = [
    ("[1, 2", None, TransportError, ""),
    ([], None, TransportError, ""),
    (b'{"id":4,"method":"\xc3("}', None, TransportError, "utf-8"),
    (b'{"id":4,"method":"pause","params":{"\x9e":1}}', 4, TransportError, "utf-8"),
    ({"id": 4}, 4, TransportError, "method"),
    ({"id": "x", "method": "stepp"}, "x", TransportError, "'step'"),
    ({"id": 1, "method": "step", "more": 1}, 1, TransportError, "more"),
    ({"id": True, "method": "step"}, None, TransportError, ""),
    ({"id": 1, "method": "step", "params": []}, 1, RequestError, "step"),
    ({"id": 1, "method": "step", "params": {"tick": 1}}, 1, RequestError, "'ticks'"),
    ({"id": 1, "method": "step", "params": {"ticks": "5"}}, 1, RequestError, "ticks"),
    ({"id": 1, "method": "step", "params": {"ticks": 0}}, 1, RequestError, "ticks"),
    ({"id": 1, "method": "save_pose"}, 1, RequestError, "name"),
    ({"id": 1, "method": "load_controller_with"}, 1, TransportError, ""),
]


@pytest.mark.parametrize(("message", "ident", "kind", "text"), BAD)
def test_a_bad_request_says_what_is_wrong(
    message: object, ident: int | str | None, kind: type[Tool0Error], text: str
) -> None:
    line = message if isinstance(message, str | bytes) else json.dumps(message)
    with pytest.raises(codec.RequestReadError) as caught:
        codec.decode_request(line)
    assert caught.value.ident == ident
    assert type(caught.value.error) is kind
    # Some of the words are msgspec's, which writes utf-8 or UTF-8.
    assert text.casefold() in str(caught.value.error).casefold()


@pytest.mark.parametrize(
    "error",
    [
        ConfigError("wrong"),
        ClaimError("two want one"),
        GoalRejectedError("old", GoalRejectedError.OLD_HEADER_TIMESTAMP),
        DivergenceError("elbow_joint", 1.5),
        RequestError("step", "'ticks': no"),
    ],
)
def test_an_error_arrives_as_it_was_raised(error: Tool0Error) -> None:
    found = codec.error_of(codec.error_info(error))
    assert type(found) is type(error)
    assert str(found) == str(error)
    assert vars(found) == vars(error)
    bug = codec.error_of(codec.error_info(ZeroDivisionError("a bug")))
    assert type(bug) is TransportError
    assert "a bug" in str(bug)


@pytest.mark.parametrize(
    "result",
    [
        GoalResult(status=GoalStatus.SUCCEEDED),
        GoalResult(status=GoalStatus.ABORTED, error_code=-4, error_string="path"),
        GripperResult(
            status=GoalStatus.SUCCEEDED,
            position=0.4,
            effort=2.0,
            stalled=True,
            reached_goal=False,
        ),
    ],
)
def test_a_result_arrives_as_it_was(result: Result) -> None:
    assert codec.result_of(codec.outcome_of(result)) == result


def test_a_snapshot_arrives_whole_and_a_stream_only_sends_changes() -> None:
    with tool0.bringup(realtime=False, scene="table_and_cubes") as robot:
        robot.move_joints({"elbow_joint": 1.4})
        robot.run(0.1)
        first = robot.snapshot
        robot.run(0.1)
        second = robot.snapshot
    text = codec.encode_reply(1, ReadSnapshot(), first)
    found = codec.decode_response(
        ReadSnapshot(), msgspec.json.decode(text, type=codec.Reply).result
    )
    for name in ("time", "position", "velocity", "effort", "objects", "controllers"):
        assert getattr(found, name) == getattr(first, name)
    assert found.setpoints() == first.setpoints()
    assert [item.name for item in found.scene] == [item.name for item in first.scene]
    change = state_message(second, StateMask(SNAPSHOT_FIELDS), first)
    assert change.scene is change.controllers is msgspec.UNSET
    after = snapshot_of(change, found)
    assert after.scene is found.scene
    assert after.position == second.position


def test_numbers_of_numpy_s_become_numbers_and_others_are_refused() -> None:
    move = checked(MoveJoints(positions={"a": np.float32(0.5)}, speed=np.float64(1.0)))
    assert move == MoveJoints(positions={"a": 0.5}, speed=1.0)
    assert type(move.positions["a"]) is float
    assert checked(Step(ticks=np.int64(3))).ticks == 3
    for bad in ("5", 1.5, None, [1], True, 0):
        with pytest.raises(RequestError):
            checked(Step(ticks=bad))  # type: ignore[arg-type]
    for value in (float("nan"), float("inf"), 10**400):
        with pytest.raises(RequestError):
            checked(MoveJoints(positions={"a": value}))
