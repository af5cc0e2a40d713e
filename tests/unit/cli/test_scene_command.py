"""``tool0 scene`` against a fake robot."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from fake_robot import FakeRobot

from tool0.cli import FAILED, OK, main
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere


@pytest.fixture(autouse=True)
def robot(served_robot: FakeRobot) -> FakeRobot:
    return served_robot


def run(line: str) -> int:
    return main(line.split())


def test_list_shows_what_is_where(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("scene list") == OK
    _, table, can = capsys.readouterr().out.splitlines()
    assert table.split()[:6] == ["table", "box", "0.5", "x", "0.8", "x"]
    assert "still" in table
    assert can.endswith("0.35 kg  +0.5000 +0.2500 -0.1250  +180.0 +0.0 +0.0")


def test_list_can_be_read_by_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("scene list --json") == OK
    table, can = json.loads(capsys.readouterr().out)["objects"]
    assert table["shape"] == {"kind": "box", "size": [0.5, 0.8, 0.04]}
    assert (can["mass"], can["friction"]) == (0.35, 0.5)
    assert can["position"] == [0.5, 0.25, -0.125]


@pytest.mark.parametrize(
    ("words", "shape"),
    [
        ("--box 0.1 0.2 0.3", Box(size=(0.1, 0.2, 0.3))),
        ("--cylinder 0.1 0.2", Cylinder(radius=0.1, length=0.2)),
        ("--sphere 0.1", Sphere(radius=0.1)),
    ],
)
def test_add_is_one_call(words: str, shape: Geometry, robot: FakeRobot) -> None:
    line = f"scene add thing {words} --xyz -0.5 0.1 0.2 --rpy 0 0 1 --mass 0.1"
    assert run(f"{line} --friction 0.7 --rgba 1 0 0 1") == OK
    others = {
        "xyz": (-0.5, 0.1, 0.2),
        "rpy": (0.0, 0.0, 1.0),
        "mass": 0.1,
        "friction": 0.7,
        "rgba": (1.0, 0.0, 0.0, 1.0),
    }
    assert robot.calls == [("add", ("thing", shape, others))]


def test_a_mesh_goes_by_its_whole_path(
    robot: FakeRobot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("part.stl").touch()
    assert run("scene add part --mesh part.stl --scale 0.001") == OK
    ((_, (_, shape, others)),) = robot.calls
    assert isinstance(shape, Mesh)
    assert shape.path == tmp_path / "part.stl"
    assert shape.scale == (0.001,) * 3
    assert (others["mass"], others["rgba"]) == (None, None)


def test_place_turns_as_well(robot: FakeRobot) -> None:
    assert run(f"scene place can --xyz 1 2 3 --rpy 0 0 {math.pi}") == OK
    ((verb, (name, position, quat_wxyz)),) = robot.calls
    assert (verb, name, position) == ("place", "can", (1.0, 2.0, 3.0))
    assert quat_wxyz == pytest.approx((0.0, 0.0, 0.0, 1.0))


def test_remove_takes_several(robot: FakeRobot) -> None:
    assert run("scene remove can table") == OK
    assert robot.calls == [("remove", "can"), ("remove", "table")]


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("scene add thing", "give one shape, --box, --cylinder, --sphere or --mesh"),
        ("scene add thing --sphere 1 --box 1 1 1", "or --mesh; got 2"),
        ("scene add thing --mesh none.stl", "there is no mesh"),
        ("scene add thing --sphere 1 --scale 2", "--scale goes with --mesh"),
        ("scene remove", "name at least one object"),
        ("scene remove cup", "there is no object 'cup'"),
    ],
)
def test_a_mistake_is_told(
    line: str, complaint: str, robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line) == FAILED
    assert complaint in capsys.readouterr().err
    assert robot.calls == []
