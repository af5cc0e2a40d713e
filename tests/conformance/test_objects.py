"""Objects of the scene: they lie still, are gripped and lifted, and go back."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM, BETWEEN_PADS, EDGE, HOME, TABLE, point

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box, Cylinder, Geometry, Sphere
from tool0.description.transform import Pose
from tool0.errors import ConfigError
from tool0.scene import shipped_scenes

SCENES = shipped_scenes()
SLIP = 1e-4  # [m] in 5 s; 1e-3 would do
CALM = 1e-4  # [m/s]
MIMIC_ERROR = {"mujoco": 2e-3, "gazebo": 1e-5}
"""[rad] while the fingers squeeze: MuJoCo's equalities are springs, if stiff ones."""


def scene_with(
    geometry: Geometry, *, mass: float = 0.1, friction: float = 1.0
) -> Scene:
    thing = SceneObject(
        name="thing",
        geometry=geometry,
        pose=Pose(xyz=BETWEEN_PADS),
        mass=mass,
        friction=friction,
    )
    return Scene((TABLE, thing))


def thing(robot: tool0.Robot) -> tuple[float, float, float]:
    return robot.snapshot.objects[1].position


@pytest.mark.parametrize(
    ("geometry", "mass", "friction"),
    [  # a light cube is gripped below
        (Box(size=(EDGE, EDGE, EDGE)), 2.0, 0.5),
        (Cylinder(radius=EDGE / 2, length=EDGE), 0.1, 1.0),
        (Sphere(radius=EDGE / 2), 0.1, 1.0),
    ],
    ids=["heavy cube", "can", "ball"],
)
def test_what_is_gripped_is_lifted_and_held(
    bring_up: BringUp, geometry: Geometry, mass: float, friction: float
) -> None:
    scene = scene_with(geometry, mass=mass, friction=friction)
    robot = bring_up(scene=scene, initial_pose="ready")
    robot.gripper.move(opening=0.0, effort=5.0)
    robot.run(1.5)
    assert robot.gripper.opening == pytest.approx(EDGE, abs=1e-3)
    robot.controller(ARM).follow([point(HOME, 2.0)]).wait(10.0)
    robot.run(1.0)
    assert thing(robot)[2] > BETWEEN_PADS[2] + 0.2  # home is higher
    offset = np.subtract(thing(robot), robot.pose("tool0").position)
    robot.run(2.0)
    held = np.subtract(thing(robot), robot.pose("tool0").position)
    np.testing.assert_allclose(held, offset, atol=2e-4)


def test_what_is_too_slippery_stays_behind(bring_up: BringUp) -> None:
    slippery = scene_with(Box(size=(EDGE, EDGE, EDGE)), mass=2.0, friction=0.02)
    robot = bring_up(scene=slippery, initial_pose="ready")
    robot.gripper.move(opening=0.0, effort=5.0)
    robot.run(1.5)
    robot.controller(ARM).follow([point(HOME, 2.0)])
    robot.run(3.0)
    assert thing(robot)[2] < BETWEEN_PADS[2] + 0.01


def test_a_reset_puts_the_objects_back(bring_up: BringUp) -> None:
    robot = bring_up(scene=scene_with(Sphere(radius=EDGE / 2)), initial_pose="ready")
    before = robot.snapshot.objects
    robot.gripper.move(opening=0.0, effort=5.0)
    robot.run(1.0)
    assert robot.snapshot.objects[1] != before[1]
    robot.reset()
    assert robot.snapshot.objects == before


def test_the_robot_tells_what_is_around_it(bring_up: BringUp) -> None:
    scene = scene_with(Sphere(radius=EDGE / 2))
    robot = bring_up(scene=scene, spawn_z=0.25)
    assert robot.scene.objects == scene.objects
    assert robot.info.ground == -0.25
    assert [pose.name for pose in robot.snapshot.objects] == ["table", "thing"]
    assert all(math.isfinite(x) for x in thing(robot))
    assert bring_up().scene.objects == ()


def test_a_scene_is_read_from_its_file(bring_up: BringUp, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    place = "pose: {xyz: [1, 1, 0]}"
    path.write_text(
        f"objects:\n- {{name: left_tool0, {place}, sphere: {{radius: 0.1}}}}\n"
    )
    (ball,) = bring_up(scene=str(path)).scene.objects
    assert ball.geometry == Sphere(radius=0.1)
    with pytest.raises(ConfigError) as error:
        bring_up(scene=path, prefix="left_")
    assert error.value.location is not None
    assert error.value.location.line == 2
    assert "'left_tool0'" in str(error.value)


def test_the_cube_that_the_original_drops_stays_between_calm_fingers(
    bring_up: BringUp, engine: str
) -> None:
    robot = bring_up(
        scene=scene_with(Box(size=(EDGE, EDGE, EDGE))), initial_pose="ready"
    )
    followers = [
        (joint.name, joint.mimic)
        for joint in robot.description.model.movable_joints
        if joint.mimic is not None
    ]
    robot.gripper.move(opening=0.0, effort=5.0)
    robot.run(1.5)
    robot.controller(ARM).follow([point(HOME, 2.0)]).wait(10.0)
    robot.run(1.0)
    start = np.subtract(thing(robot), robot.pose("tool0").position)
    errors, speeds = [], []
    for _ in range(625):  # 5 s
        before = np.array(thing(robot))
        robot.run(0.008)  # a snapshot is as old
        speeds.append(np.linalg.norm(thing(robot) - before) / 0.008)
        position = robot.joint_state.position
        errors += [
            abs(position[name] - mimic.multiplier * position[mimic.joint])
            for name, mimic in followers
        ]
    slip = np.subtract(thing(robot), robot.pose("tool0").position) - start
    assert np.linalg.norm(slip) <= SLIP
    assert max(speeds) <= CALM
    assert max(errors) <= MIMIC_ERROR[engine]


@pytest.mark.parametrize("name", SCENES)
def test_nothing_overlaps_and_nothing_moves(
    bring_up: BringUp, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        robot = bring_up(scene=name)
        before = robot.snapshot.objects
        assert before
        robot.run(2.0)
        for start, end in zip(before, robot.snapshot.objects, strict=True):
            np.testing.assert_allclose(end.position, start.position, atol=1e-4)
            np.testing.assert_allclose(end.quat_wxyz, start.quat_wxyz, atol=1e-4)
    assert caplog.records == []


def test_there_are_scenes() -> None:
    assert {"table_and_bin", "table_and_cubes"} <= SCENES.keys()
