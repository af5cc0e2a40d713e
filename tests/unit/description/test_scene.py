import math
from pathlib import Path
from typing import Any

import pytest

from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box, Cylinder, Mesh, Sphere
from tool0.description.transform import Pose
from tool0.errors import ConfigError

BOX = Box(size=(0.1, 0.1, 0.1))


def with_geometry(geometry: Any) -> SceneObject:
    return SceneObject(name="thing", geometry=geometry)


@pytest.mark.parametrize("name", ["cube", "red cube", "box_2", "a.b-c", "红色方块"])
def test_a_name_is_what_people_write(name: str) -> None:
    assert SceneObject(name=name, geometry=BOX).name == name


@pytest.mark.parametrize("name", ["", " ", "a/b", " cube", "cube ", "a  b", "a\nb"])
def test_a_name_that_could_not_be_printed_or_be_a_path_is_refused(name: str) -> None:
    with pytest.raises(ConfigError, match="cannot name an object"):
        SceneObject(name=name, geometry=BOX)


@pytest.mark.parametrize("bad", [0.0, -0.1, math.nan, math.inf])
def test_a_shape_without_a_size_is_refused(bad: float) -> None:
    for geometry in (
        Box(size=(0.1, bad, 0.1)),
        Cylinder(radius=bad, length=0.1),
        Cylinder(radius=0.1, length=bad),
        Sphere(radius=bad),
    ):
        with pytest.raises(ConfigError, match="of object 'thing' must be above 0 m"):
            with_geometry(geometry)


@pytest.mark.parametrize("bad", [0.0, math.nan, math.inf])
def test_a_mesh_needs_a_scale(bad: float, tmp_path: Path) -> None:
    mesh = Mesh(uri="a.stl", path=tmp_path / "a.stl", scale=(1.0, 1.0, bad))
    with pytest.raises(ConfigError, match="scale of the mesh of object 'thing'"):
        with_geometry(mesh)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"mass": 0.0}, "mass of object 'thing' must be above 0 kg and finite, got 0;"),
        ({"mass": -1.0}, "mass of object 'thing'"),
        ({"mass": math.nan}, "mass of object 'thing'"),
        ({"mass": math.inf}, "mass of object 'thing'"),
        ({"friction": -0.1}, "friction of object 'thing' must be 0 or more"),
        ({"friction": math.nan}, "friction of object 'thing'"),
        ({"rgba": (0.0, 0.0, 1.1, 1.0)}, "rgba of object 'thing'"),
        ({"rgba": (0.0, 0.0, math.nan, 1.0)}, "rgba of object 'thing'"),
        ({"rgba": (0.0, 0.0, 0.0)}, "rgba of object 'thing' must be four"),
        ({"pose": Pose(xyz=(0.0, math.nan, 0.0))}, "pose of object 'thing'"),
        ({"pose": Pose(rpy=(0.0, math.inf, 0.0))}, "pose of object 'thing'"),
    ],
)
def test_numbers_that_no_object_has_are_refused(
    fields: dict[str, Any], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        SceneObject(name="thing", geometry=BOX, **fields)


def test_objects_have_a_name_each() -> None:
    item = with_geometry(BOX)
    with pytest.raises(ConfigError, match="two objects are called 'thing'"):
        Scene((item, item))


def test_no_object_is_called_like_a_link(skew_model: RobotModel) -> None:
    link = skew_model.links[-1].name
    Scene((with_geometry(BOX),)).check_beside(skew_model)
    with pytest.raises(ConfigError, match=f"object '{link}' has the name of a link"):
        Scene((SceneObject(name=link, geometry=BOX),)).check_beside(skew_model)


def test_no_object_is_called_like_the_ground(skew_model: RobotModel) -> None:
    with pytest.raises(ConfigError, match="no object can be called 'ground'"):
        Scene((SceneObject(name="ground", geometry=BOX),)).check_beside(skew_model)
