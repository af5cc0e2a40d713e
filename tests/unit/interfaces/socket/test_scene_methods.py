"""What a peer may say of objects."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from fake_robot import CAN, TABLE, FakeRobot
from tool0.interfaces.socket.client import RemoteRobot
from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.remote_scene import RemoteScene
from tool0.interfaces.socket.scene_methods import SCENE_CALLS
from tool0.interfaces.socket.wire import Json

from tool0.description.shapes import Box
from tool0.errors import DescriptionError, EngineError, TransportError


@pytest.fixture
def robot(served_robot: FakeRobot) -> FakeRobot:
    return served_robot


@pytest.fixture
def scene(robot: FakeRobot) -> Iterator[RemoteScene]:
    with RemoteRobot() as remote:
        yield remote.scene


def test_the_objects_are_the_robot_s(robot: FakeRobot, scene: RemoteScene) -> None:
    found = scene.list()
    assert [item.state for item in found] == list(robot.snapshot.objects)
    assert [item.shape for item in found] == [TABLE.geometry, CAN.geometry]
    assert [item.mass for item in found] == [None, CAN.mass]


def test_verbs_reach_the_robot(robot: FakeRobot, scene: RemoteScene) -> None:
    scene.add("cube", Box(size=(1.0, 1.0, 1.0)))
    scene.place("cube", [1, 2, 3])
    scene.remove("can")
    assert [verb for verb, _ in robot.calls] == ["add", "place", "remove"]
    with pytest.raises(EngineError, match="'cub'"):
        scene.remove("cub")


BOX = {"name": "a", "kind": "box", "size": [1, 1, 1]}


@pytest.mark.parametrize(
    ("method", "params", "complaint"),
    [
        ("scene.list", {"name": "a"}, "unknown parameter 'name'"),
        ("scene.add", {**BOX, "kind": "bx"}, "no kind of shape 'bx'; did you mean"),
        ("scene.add", {**BOX, "kind": "sphere"}, "parameter 'radius' is missing"),
        ("scene.add", {**BOX, "size": [1, 1]}, "'size' must be a list of three"),
        ("scene.add", {**BOX, "size": [1, 1, "1"]}, "'size' must be a number"),
        ("scene.add", {**BOX, "rgba": [1, 1, 1]}, "'rgba' has four parts, got 3"),
        ("scene.add", {**BOX, "mas": 1}, "unknown parameter 'mas'; did you mean 'm"),
        ("scene.place", {"name": "a"}, "parameter 'xyz' is missing"),
    ],
)
def test_what_makes_no_sense_is_refused(
    method: str, params: Json, complaint: str, robot: FakeRobot
) -> None:
    with pytest.raises(TransportError, match=complaint):
        SCENE_CALLS[method](robot, Params(method, params))
    assert robot.calls == []


def test_a_mesh_that_is_not_there_is_told(robot: FakeRobot) -> None:
    params = Params("scene.add", {"name": "a", "kind": "mesh", "file": "none.stl"})
    with pytest.raises(DescriptionError, match="there is no mesh"):
        SCENE_CALLS["scene.add"](robot, params)
