from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from raises_naming import raises_naming

import tool0
from tool0 import scene
from tool0.description.scene import PALETTE, STILL_RGBA
from tool0.errors import ConfigError, ControlError, DescriptionError, RequestError
from tool0.protocol.objects import AddModel
from tool0.scene import Box, Compound, Pose, SceneObject, Sphere
from tool0.simulation.handlers.objects import MOST_SHAPES

BOX = Box(size=(0.1, 0.1, 0.1))
TETRAHEDRON = """
v 0 0 0
v 100 0 0
v 0 100 0
v 0 0 100
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


@pytest.fixture(scope="module")
def shared() -> Iterator[tool0.Robot]:
    with tool0.bringup(gripper=None, realtime=False) as robot:
        yield robot


@pytest.fixture
def robot(shared: tool0.Robot) -> tool0.Robot:
    for name in shared.scene:
        shared.scene.remove(name)
    return shared


def test_what_is_added_is_there_until_it_is_removed(robot: tool0.Robot) -> None:
    item = robot.scene.add("cube", BOX, xyz=(2.0, 0.0, 1.0), mass=0.2, friction=0.7)
    assert item == SceneObject(
        name="cube",
        geometry=BOX,
        pose=Pose(xyz=(2.0, 0.0, 1.0)),
        mass=0.2,
        friction=0.7,
        rgba=PALETTE[0],
    )
    assert robot.scene.objects == (item,)
    assert robot.scene["cube"] == item
    assert "cube" in robot.scene
    assert list(robot.scene) == ["cube"]
    assert len(robot.scene) == 1
    robot.scene.remove("cube")
    assert "cube" not in robot.scene
    assert robot.scene.add(item) == item  # the same again


def test_it_says_where_things_are_and_how_they_move(robot: tool0.Robot) -> None:
    robot.scene.add("ball", Sphere(radius=0.1), xyz=(2.0, 0.0, 1.0), mass=1.0)
    robot.scene.place("ball", np.array([2, 1, 1]), [0, 0, 0, 2], linear=np.ones(3))
    state = robot.scene.states["ball"]
    assert (state.linear, state.angular) == ((1, 1, 1), (0, 0, 0))
    assert all(type(part) is float for part in (*state.position, *state.linear))
    pose = robot.scene.pose("ball")
    assert pose.position == (2.0, 1.0, 1.0)
    assert pose.quat_wxyz == pytest.approx((0, 0, 0, 1))


def test_what_names_no_colour_gets_one(robot: tool0.Robot) -> None:
    colors = [
        robot.scene.add(name, BOX, xyz=(2.0, y, 1.0), mass=mass).rgba
        for name, y, mass in (("a", 0.0, 1.0), ("b", 1.0, None), ("c", 2.0, 1.0))
    ]
    assert colors == [PALETTE[0], STILL_RGBA, PALETTE[1]]
    red = (1.0, 0.0, 0.0, 1.0)
    assert robot.scene.add("d", BOX, xyz=(2.0, 3.0, 1.0), rgba=red).rgba == red


def test_a_mesh_goes_by_its_path(robot: tool0.Robot, tmp_path: Path) -> None:
    path = tmp_path / "part.obj"
    path.write_text(TETRAHEDRON)
    shape = scene.mesh(path, scale=0.001)
    assert shape.scale == (0.001, 0.001, 0.001)
    robot.scene.add("small", shape, xyz=(2.0, 0.0, 1.0), mass=0.1)
    large = robot.scene.add("large", str(path), xyz=(200.0, 0.0, 1.0))
    assert large.geometry == scene.mesh(path)
    with pytest.raises(DescriptionError):
        robot.scene.add("other", tmp_path / "other.obj")
    assert list(robot.scene) == ["small", "large"]


def test_an_object_may_have_several_shapes(robot: tool0.Robot) -> None:
    shape = Compound(
        parts=((BOX, Pose()), (Sphere(radius=0.1), Pose(xyz=(0.2, 0.0, 0.0))))
    )
    item = robot.scene.add("mug", shape, xyz=(2.0, 0.0, 1.0), mass=0.3)
    assert item.geometry == shape
    assert robot.scene["mug"] == item


@pytest.mark.parametrize("parts", [(), 3, (BOX,), [(BOX, Pose())], ((BOX, (0, 0, 0)),)])
def test_a_compound_is_made_of_shapes_with_poses(parts: object) -> None:
    with raises_naming(ConfigError, "(shape, Pose)"):
        Compound(parts=parts)  # type: ignore[arg-type]


def test_the_parts_of_a_compound_are_checked(robot: tool0.Robot) -> None:
    for part in (
        (Sphere(radius=-1.0), Pose()),
        (BOX, Pose(xyz=(float("nan"), 0.0, 0.0))),
    ):
        with raises_naming(ConfigError, "shape 2 of object 'x'"):
            SceneObject(name="x", geometry=Compound(parts=((BOX, Pose()), part)))
    many = Compound(parts=((BOX, Pose()),) * (MOST_SHAPES + 1))
    with raises_naming(ConfigError, f"{MOST_SHAPES + 1} shapes"):
        robot.scene.add("x", many)
    half = Compound(parts=many.parts[: MOST_SHAPES // 2 + 1])
    robot.scene.add("half", half, xyz=(2.0, 0.0, 1.0))
    with raises_naming(ConfigError, f"{2 * len(half.parts)} shapes"):
        robot.scene.add("x", half)
    assert list(robot.scene) == ["half"]


def test_what_cannot_be_is_refused(robot: tool0.Robot) -> None:
    robot.scene.add("cube", BOX, xyz=(2.0, 0.0, 1.0))
    for options, named in (({"mass": -1.0}, "mass"), ({"rpy": [0.1]}, "rpy")):
        with raises_naming(RequestError, named):
            robot.scene.add("x", BOX, **options)
    for part in ({"quat_wxyz": (1.0, 0.0, 0.0)}, {"linear": (1.0,)}, {"angular": ()}):
        with pytest.raises(ControlError):
            robot.scene.place("cube", (0.0, 0.0, 1.0), **part)
    with pytest.raises(ConfigError):
        robot.scene.add("tool0", BOX, xyz=(2.0, 0.0, 2.0))
    with raises_naming(RequestError, "shape"):
        robot.scene.add("x", Box(size=(1.0, 2.0)))  # type: ignore[arg-type]
    with pytest.raises(ControlError, match="needs a shape"):
        robot.scene.add("x")  # type: ignore[call-overload]
    for look in (robot.scene.pose, robot.scene.__getitem__):
        with raises_naming(ControlError, "'cub'"):
            look("cub")
    assert list(robot.scene) == ["cube"]


MODEL = """
<sdf version="1.6"><model name="box"><pose>0 0 0.1 0 0 0</pose><link name="link">
  <pose>0.2 0 0 0 0 0</pose><inertial><mass>0.5</mass></inertial>
  <collision name="c"><geometry><box><size>0.1 0.2 0.3</size></box></geometry>
  </collision>
</link></model></sdf>
"""


def test_a_model_becomes_an_object(robot: tool0.Robot) -> None:
    turned = (0.5**0.5, 0.0, 0.0, 0.5**0.5)  # x of the model is y of the root
    request = AddModel(name="m", model=MODEL, xyz=(1.0, 1.0, 1.0), quat_wxyz=turned)
    placed = robot.channel.call(request)
    np.testing.assert_allclose(placed.xyz, (0.2, 0.0, 0.1), atol=1e-12)
    (item,) = robot.snapshot.scene
    assert (item.name, item.mass) == ("m", 0.5)
    assert item.geometry == Box(size=(0.1, 0.2, 0.3))
    np.testing.assert_allclose(item.pose.xyz, (1.0, 1.2, 1.1), atol=1e-12)


def test_what_is_no_model_is_refused(robot: tool0.Robot) -> None:
    call = robot.channel.call
    with pytest.raises(DescriptionError, match="<robot>"):
        call(AddModel(name="m", model="<nothing/>"))
    with pytest.raises(RequestError, match="'model'"):
        call(AddModel(name="m", model=" " * 1_000_001))
    with pytest.raises(ConfigError, match="quat_wxyz"):
        call(AddModel(name="m", model=MODEL, quat_wxyz=(0.0, 0.0, 0.0, 0.0)))
    assert not robot.snapshot.scene
