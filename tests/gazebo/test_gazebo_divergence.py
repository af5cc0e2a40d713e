"""What is no number any more, in Gazebo: it is told of, and a reset makes good."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from in_gazebo import BringUp

import tool0
from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.engines.gazebo.engine import GazeboEngine
from tool0.errors import DivergenceError

CUBE = SceneObject(
    name="cube",
    geometry=Box(size=(0.04, 0.04, 0.04)),
    pose=Pose(xyz=(2.0, 0.0, -0.08)),
    mass=0.1,
)
TOO_FAST = 1e308  # [m/s]; the sum of two is beyond all numbers


def push_too_hard(robot: tool0.Robot, engine: GazeboEngine) -> None:
    """Push until all bodies of the robot are nowhere, and make further steps."""
    for _ in range(3):
        engine.write([1e300] * len(engine.joint_names))
        engine.step()
        with pytest.raises(DivergenceError) as error:
            engine.read()
        assert error.value.joint == "shoulder_pan_joint"


def throw_too_fast(robot: tool0.Robot, engine: GazeboEngine) -> None:
    robot.scene.add(CUBE)
    xyz, upright = CUBE.pose.xyz, (1.0, 0.0, 0.0, 0.0)
    fast = (TOO_FAST, TOO_FAST, 0.0)
    engine.world.place(ObjectState("cube", xyz, upright, fast, (0.0, 0.0, 0.0)))
    with pytest.raises(DivergenceError) as error:
        robot.run(0.01)
    assert error.value.joint == "cube"
    robot.reset()
    (cube,) = engine.world.object_states()
    assert cube.position == pytest.approx(xyz)
    assert not any((*cube.linear, *cube.angular))
    robot.scene.remove("cube")


@pytest.mark.parametrize("diverge", [push_too_hard, throw_too_fast])
def test_after_a_reset_a_diverged_robot_is_as_new(
    diverge: Callable[[tool0.Robot, GazeboEngine], None], bring_up: BringUp
) -> None:
    robot, engine = bring_up()
    robot.run(0.5)
    as_new = robot.snapshot
    diverge(robot, engine)
    for _ in range(2):
        robot.reset()
        robot.run(0.5)
        assert robot.snapshot.position == as_new.position
        assert robot.snapshot.velocity == as_new.velocity
        assert robot.snapshot.effort == as_new.effort


def test_a_deep_overlap_is_undone_gently(bring_up: BringUp) -> None:
    """ODE's direct solver overlooks <max_vel>, and threw such a cube 6 m high."""
    robot, _ = bring_up()
    table = SceneObject(
        name="table", geometry=Box(size=(0.2, 0.2, 0.4)), pose=Pose(xyz=(2.0, 0.0, 0.1))
    )
    robot.scene.add(table)
    robot.scene.add(replace(CUBE, pose=Pose(xyz=(2.0, 0.0, 0.3))))
    fastest = 0.0
    for _ in range(30):
        robot.run(0.001)
        cube = robot.snapshot.objects[-1]
        fastest = max(fastest, *map(abs, (*cube.linear, *cube.angular)))
    assert 0.4 < fastest < 0.51
    robot.run(0.5)
    assert robot.snapshot.objects[-1].position == pytest.approx(
        (2.0, 0.0, 0.32), abs=1e-4
    )


def test_a_table_that_comes_into_the_gripper_pushes_it_out_of_the_way(
    bring_up: BringUp,
) -> None:
    robot, _ = bring_up()
    robot.run(0.014)
    robot.scene.add(
        SceneObject(
            name="table",
            geometry=Box(size=(0.2, 0.2, 0.4)),
            pose=Pose(xyz=(0.6, 0.1, 0.1)),
        ),
        allow_penetration=True,
    )
    fastest = 0.0
    for _ in range(200):
        robot.run(0.001)
        fastest = max(fastest, *map(abs, robot.snapshot.velocity))
    assert fastest < 5.0  # [rad/s]; it was 120
    assert max(map(abs, robot.snapshot.velocity)) < 0.5
