"""Objects, scenes and bins as values: what they are, and what is refused."""

import itertools
import math
import re
import tracemalloc
from pathlib import Path
from typing import Any

import pytest

from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject, bin_walls
from tool0.description.shapes import Box, Cylinder, Mesh, Sphere, mesh
from tool0.description.transform import Pose
from tool0.errors import ConfigError, DescriptionError

BOX = Box(size=(0.1, 0.1, 0.1))


def with_geometry(geometry: Any) -> SceneObject:
    return SceneObject(name="thing", geometry=geometry)


@pytest.mark.parametrize("name", ["cube", "red cube", "box_2", "a.b-c", "红色方块"])
def test_a_name_is_what_people_write(name: str) -> None:
    assert SceneObject(name=name, geometry=BOX).name == name


@pytest.mark.parametrize("name", ["", " ", "a/b", " cube", "cube ", "a  b", "a\nb"])
def test_a_name_that_could_not_be_printed_or_be_a_path_is_refused(name: str) -> None:
    with pytest.raises(ConfigError):
        SceneObject(name=name, geometry=BOX)


@pytest.mark.parametrize("bad", [0.0, -0.1, math.nan, math.inf])
def test_a_shape_without_a_size_is_refused(bad: float) -> None:
    for geometry in (
        Box(size=(0.1, bad, 0.1)),
        Cylinder(radius=bad, length=0.1),
        Cylinder(radius=0.1, length=bad),
        Sphere(radius=bad),
    ):
        with pytest.raises(ConfigError) as caught:
            with_geometry(geometry)
        assert "'thing'" in str(caught.value)


@pytest.mark.parametrize("bad", [0.0, math.nan, math.inf])
def test_a_mesh_needs_a_scale(bad: float, tmp_path: Path) -> None:
    with pytest.raises(ConfigError):
        with_geometry(Mesh(uri="a.stl", path=tmp_path, scale=(1.0, 1.0, bad)))


BAD_FIELDS: list[tuple[str, Any]] = [
    *(("mass", value) for value in (0.0, -1.0, math.nan, math.inf)),
    *(("friction", value) for value in (-0.1, math.nan)),
    *(("rgba", rgba) for rgba in ((0, 0, 1.1, 1), (0, 0, math.nan, 1), (0, 0, 0))),
    ("pose", Pose(xyz=(0.0, math.nan, 0.0))),
    ("pose", Pose(rpy=(0.0, math.inf, 0.0))),
]


@pytest.mark.parametrize(("field", "value"), BAD_FIELDS)
def test_numbers_that_no_object_has_are_refused(field: str, value: object) -> None:
    with pytest.raises(ConfigError) as caught:
        SceneObject(name="thing", geometry=BOX, **{field: value})  # type: ignore[arg-type]
    assert f"the {field} of object 'thing'" in str(caught.value)


def test_objects_have_a_name_each() -> None:
    item = with_geometry(BOX)
    with pytest.raises(ConfigError):
        Scene((item, item))


def test_no_object_is_called_like_a_link_or_the_ground(skew_model: RobotModel) -> None:
    Scene((with_geometry(BOX),)).check_beside(skew_model)
    for name in (skew_model.links[-1].name, "ground"):
        with pytest.raises(ConfigError) as caught:
            Scene((SceneObject(name=name, geometry=BOX),)).check_beside(skew_model)
        assert f"'{name}'" in str(caught.value)


SIZE = (0.3, 0.2, 0.1)
WALL = 0.004


def interval(item: SceneObject, axis: int) -> tuple[float, float]:
    """Return from where to where a part that is not turned reaches [m]."""
    assert isinstance(item.geometry, Box)
    centre, half = item.pose.xyz[axis], item.geometry.size[axis] / 2
    return centre - half, centre + half


def test_a_bin_s_parts_fill_its_size_without_overlap() -> None:
    parts = bin_walls("bin", size=SIZE, wall=WALL)
    for axis in range(3):
        ends = [end for item in parts for end in interval(item, axis)]
        assert min(ends) == pytest.approx(-SIZE[axis] / 2)
        assert max(ends) == pytest.approx(SIZE[axis] / 2)
    for one, two in itertools.combinations(parts, 2):
        overlaps = [
            min(interval(one, axis)[1], interval(two, axis)[1])
            - max(interval(one, axis)[0], interval(two, axis)[0])
            for axis in range(3)
        ]
        assert min(overlaps) < 1e-12
    inside = (SIZE[0] - 2 * WALL) * (SIZE[1] - 2 * WALL) * (SIZE[2] - WALL)
    volume = sum(math.prod(i.geometry.size) for i in parts if type(i.geometry) is Box)
    assert volume == pytest.approx(math.prod(SIZE) - inside)


def test_a_bin_is_turned_as_a_whole() -> None:
    pose = Pose(xyz=(1.0, 2.0, 3.0), rpy=(0.0, 0.0, math.pi / 2))
    parts = {i.name: i for i in bin_walls("b", size=SIZE, wall=WALL, pose=pose)}
    front = parts["b.front"].pose
    assert front.rpy == pose.rpy
    assert front.xyz == pytest.approx((1.0, 2.0 + (0.3 - WALL) / 2, 3.0 + WALL / 2))
    assert all(item.mass is None for item in parts.values())


@pytest.mark.parametrize("wall", [0.0, -0.01, 0.1, math.nan, math.inf])
def test_the_walls_of_a_bin_leave_room_inside(wall: float) -> None:
    with pytest.raises(ConfigError):
        bin_walls("b", size=SIZE, wall=wall)


@pytest.mark.parametrize(
    ("name", "start", "size", "said"),
    [
        ("a.stl", b"", 10**9, "has 1,000 MB; use one of at most 100 MB"),
        ("a.stl", b"solid ", 10**9, "1,000 MB"),
        ("a.obj", b"v 0 0 0\n", 10**9, "1,000 MB"),
        ("a.dae", b"", 10**9, "1,000 MB"),
        ("a.stl", b"", 90_000_000, "its header says 0 triangles"),
        ("a.stl", b"\0" * 80 + b"\xff" * 4, 1_000, "4,294,967,295 triangles"),
        ("a.STL", b"\0" * 80 + b"\2\0\0\0", 183, "184 bytes, and the file has 183"),
    ],
)
def test_a_mesh_of_the_wrong_size_is_refused_before_it_is_read(
    name: str, start: bytes, size: int, said: str, tmp_path: Path
) -> None:
    file = tmp_path / name
    with file.open("wb") as stream:
        stream.write(start)
        stream.truncate(size)  # sparse: it takes no space
    tracemalloc.start()
    try:
        with pytest.raises(DescriptionError, match=re.escape(said)):
            mesh(file)
        assert tracemalloc.get_traced_memory()[1] < 1e5
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("spare", [0, 12])
def test_a_mesh_of_the_right_size_is_taken(spare: int, tmp_path: Path) -> None:
    file = tmp_path / "a.stl"
    file.write_bytes(b"\0" * 80 + b"\2\0\0\0" + b"\0" * (100 + spare))
    assert mesh(file).path == file
