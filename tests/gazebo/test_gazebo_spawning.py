"""Objects that come and go in Gazebo, where it has ways of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest
from in_gazebo import BringUp, gz

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box, Geometry, Mesh
from tool0.description.transform import Pose
from tool0.errors import EngineError

TABLE = SceneObject(
    name="table", geometry=Box(size=(0.4, 0.4, 0.04)), pose=Pose(xyz=(2.0, 0.0, 0.5))
)
CUBE = SceneObject(
    name="cube",
    geometry=Box(size=(0.04, 0.04, 0.04)),
    pose=Pose(xyz=(2.0, 0.0, 0.54)),
    mass=0.1,
)
TETRAHEDRON = """\
v 0.0 0.0 0.0
v 0.2 0.0 0.0
v 0.0 0.2 0.0
v 0.0 0.0 0.2
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def meshed(path: Path, *, mass: float | None = None) -> SceneObject:
    geometry: Geometry = Mesh(uri=path.name, path=path)
    return SceneObject(name="part", geometry=geometry, pose=TABLE.pose, mass=mass)


def height(robot: tool0.Robot, name: str) -> float:
    return next(o.position[2] for o in robot.snapshot.objects if o.name == name)


def test_what_comes_under_the_name_of_what_went_stays(bring_up: BringUp) -> None:
    robot, engine = bring_up(scene=Scene((TABLE, CUBE)))
    robot.run(0.3)
    robot.scene.remove("table")
    robot.scene.add(TABLE)
    # Gazebo deletes by name what it was told, and looks every 0.2 s of wall time.
    robot.run(5.0)
    assert gz(engine, "model", "-m", "table", "-p").split()[:3] == ["2", "0", "0.6"]
    assert height(robot, "cube") == pytest.approx(0.54, abs=1e-4)


@pytest.mark.parametrize("way", ["deleted", "placed"])
def test_what_slept_on_what_goes_falls(way: str, bring_up: BringUp) -> None:
    robot, _ = bring_up(scene=Scene((TABLE, CUBE)))
    robot.run(3.0)
    assert robot.snapshot.objects[1].linear == (0.0, 0.0, 0.0)  # ODE put it to sleep
    if way == "deleted":
        robot.scene.remove("table")
    else:
        robot.scene.place("table", (3.0, 0.0, 0.5))
    robot.run(0.2)
    assert height(robot, "cube") < 0.54 - 0.15


def test_velocities_are_those_of_the_origin_wherever_the_mass_is(
    tmp_path: Path, bring_up: BringUp
) -> None:
    path = tmp_path / "tetrahedron.obj"
    path.write_text(TETRAHEDRON)
    robot, engine = bring_up()
    robot.scene.add(meshed(path, mass=1.0))
    told = ObjectState(
        "part", (2.0, 0.0, 0.5), (1.0, 0.0, 0.0, 0.0), (0.1, 0.2, 1.0), (0.0, 0.0, 3.0)
    )
    engine.world.place(told)
    (placed,) = engine.world.object_states()
    assert placed.linear == pytest.approx(told.linear)
    assert placed.angular == pytest.approx(told.angular)
    engine.step()
    (moved,) = engine.world.object_states()
    way = np.subtract(moved.position, placed.position)
    np.testing.assert_allclose(way, np.multiply(told.linear, engine.dt), atol=2e-5)


def test_what_somebody_else_deleted_can_be_deleted_and_come_again(
    bring_up: BringUp,
) -> None:
    robot, engine = bring_up(scene=Scene((TABLE, CUBE)))
    robot.run(0.1)
    gz(engine, "model", "-m", "cube", "-d")
    for _ in range(3):
        robot.run(1.0)
        robot.reset()
    with pytest.raises(EngineError):
        robot.scene.add(CUBE)
    robot.scene.remove("cube")
    robot.scene.add(CUBE)
    robot.run(2.0)
    assert height(robot, "cube") == pytest.approx(0.54, abs=1e-4)


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".dae", ".xyz"])
def test_meshes_that_gazebo_would_leave_out_are_refused(
    suffix: str, tmp_path: Path, bring_up: BringUp
) -> None:
    robot, engine = bring_up()
    path = tmp_path / f"part{suffix}"
    for _ in range(2):  # there is no file, and then there is a wrong one
        with pytest.raises(tool0.Tool0Error) as error:
            robot.scene.add(meshed(path))
        assert str(path) in str(error.value)
        path.write_text("nonsense")
    with pytest.raises(EngineError):
        engine.world.delete("part")
    robot.run(0.1)
    assert robot.scene.objects == ()


@pytest.mark.parametrize(
    ("name", "taken_by"),
    [
        ("sun", "sun"),
        ("elbow_joint", "ur5_robot::elbow_joint"),
        ("collision", "ground_plane::link::collision"),
    ],
)
def test_a_name_in_gazebos_world_is_refused_without_waiting(
    name: str, taken_by: str, bring_up: BringUp
) -> None:
    """Gazebo finds the first of two: for 10 s it would not find the object."""
    robot, engine = bring_up()
    start = perf_counter()
    with pytest.raises(EngineError) as error:
        robot.scene.add(replace(CUBE, name=name))
    assert f"'{taken_by}'" in str(error.value)
    assert perf_counter() - start < 1.0
    assert robot.scene.objects == ()
    with pytest.raises(EngineError):
        engine.world.delete(name)
