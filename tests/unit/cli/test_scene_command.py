"""``tool0 scene`` with a robot that runs."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest

import tool0
from tool0.cli import OK, main
from tool0.description.shapes import Box, Compound, Cylinder, Geometry, Mesh, Sphere
from tool0.description.transform import Pose

TETRAHEDRON = """
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def run(line: str) -> int:
    return main(line.split())


@pytest.fixture
def furnished(robot: tool0.Robot) -> tool0.Robot:
    robot.pause()  # nothing falls
    robot.scene.add("table", Box(size=(0.5, 0.8, 0.04)), xyz=(0.6, 0.0, 0.0))
    robot.scene.add(
        "can",
        Cylinder(radius=0.03, length=0.1),
        xyz=(0.5, 0.25, 0.2),
        rpy=(math.pi, 0.0, 0.0),
        mass=0.35,
        friction=0.5,
    )
    return robot


def test_list_shows_what_is_where(
    furnished: tool0.Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("scene list") == OK
    _, table, can = capsys.readouterr().out.splitlines()
    assert table.split()[:7] == ["table", "box", "0.5", "x", "0.8", "x", "0.04"]
    assert "fixed" in table
    words = can.split()
    assert words[:6] == ["can", "cylinder", "0.03", "x", "0.1", "0.35"]
    assert words[7:10] == ["+0.5000", "+0.2500", "+0.2000"]
    assert words[11:] == ["+0.0", "+0.0"]


def test_list_counts_the_shapes_of_an_object(
    furnished: tool0.Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    part = (Sphere(radius=0.1), Pose(xyz=(0.1, 0.0, 0.0)))
    furnished.scene.add("mug", Compound(parts=(part, part)), xyz=(2.0, 0.0, 1.0))
    assert run("scene list") == OK
    assert capsys.readouterr().out.splitlines()[-1].split()[:3] == [
        "mug",
        "2",
        "shapes",
    ]
    assert run("scene list --json") == OK
    mug = json.loads(capsys.readouterr().out)["objects"][-1]
    sphere = {"kind": "sphere", "radius": 0.1}
    sent = {"shape": sphere, "xyz": [0.1, 0.0, 0.0], "rpy": [0.0, 0.0, 0.0]}
    assert mug["shape"] == {"kind": "compound", "parts": [sent, sent]}


def test_list_can_be_read_by_programs(
    furnished: tool0.Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("scene list --json") == OK
    table, can = json.loads(capsys.readouterr().out)["objects"]
    assert table["shape"] == {"kind": "box", "size": [0.5, 0.8, 0.04]}
    assert (can["mass"], can["friction"]) == (0.35, 0.5)
    assert can["position"] == pytest.approx([0.5, 0.25, 0.2])


@pytest.mark.parametrize(
    ("words", "shape"),
    [
        ("--box 0.1 0.2 0.3", Box(size=(0.1, 0.2, 0.3))),
        ("--cylinder 0.1 0.2", Cylinder(radius=0.1, length=0.2)),
        ("--sphere 0.1", Sphere(radius=0.1)),
    ],
)
def test_an_object_is_added_as_it_is_described(
    words: str, shape: Geometry, robot: tool0.Robot
) -> None:
    line = f"scene add thing {words} --xyz -0.5 0.1 0.4 --rpy 0 0 1 --mass 0.1"
    assert run(f"{line} --friction 0.7 --rgba 1 0 0 1") == OK
    added = robot.scene["thing"]
    assert added.geometry == shape
    assert added.pose == Pose(xyz=(-0.5, 0.1, 0.4), rpy=(0.0, 0.0, 1.0))
    assert (added.mass, added.friction) == (0.1, 0.7)
    assert added.rgba == (1.0, 0.0, 0.0, 1.0)


def test_a_mesh_is_found_from_the_folder_of_the_command(
    robot: tool0.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("part.obj").write_text(TETRAHEDRON)
    assert run("scene add part --mesh part.obj --scale 0.1 --xyz 1 0 0.5") == OK
    shape = robot.scene["part"].geometry
    assert isinstance(shape, Mesh)
    assert shape.path == tmp_path / "part.obj"
    assert shape.scale == (0.1,) * 3
    assert robot.scene["part"].mass is None


def test_place_turns_as_well(furnished: tool0.Robot) -> None:
    assert run(f"scene place can --xyz 1 2 3 --rpy 0 0 {math.pi}") == OK
    pose = furnished.scene.pose("can")
    assert pose.position == pytest.approx((1.0, 2.0, 3.0))
    assert pose.quat_wxyz == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=1e-9)


def test_remove_takes_several(furnished: tool0.Robot) -> None:
    assert run("scene remove can table") == OK
    assert len(furnished.scene) == 0


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("scene add thing", "--cylinder"),
        ("scene add thing --sphere 1 --box 1 1 1", "2"),
        ("scene add thing --mesh none.stl", "none.stl"),
        ("scene add thing --sphere 1 --scale 2", "--mesh"),
        ("scene remove", "OBJECT ... is missing"),
        ("scene remove cup", "'cup'"),
    ],
)
def test_a_mistake_is_one_line_and_adds_nothing(
    line: str, named: str, refused: Callable[[str], str]
) -> None:
    assert named in refused(line)
