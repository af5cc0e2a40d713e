"""What is no number any more, in Gazebo: it is told of, and a reset makes good."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from in_gazebo import BringUp

import tool0
from tool0.description.model import Box, Pose
from tool0.description.scene import SceneObject
from tool0.engines.gazebo.engine import GazeboEngine
from tool0.errors import DivergenceError
from tool0.hardware.engine import ObjectState

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
        with pytest.raises(DivergenceError, match="joint 'shoulder_pan_joint'"):
            engine.read()


def throw_too_fast(robot: tool0.Robot, engine: GazeboEngine) -> None:
    robot.spawn(CUBE)
    xyz, upright = CUBE.pose.xyz, (1.0, 0.0, 0.0, 0.0)
    fast = (TOO_FAST, TOO_FAST, 0.0)
    engine.place(ObjectState("cube", xyz, upright, fast, (0.0, 0.0, 0.0)))
    with pytest.raises(DivergenceError, match="object 'cube' is not finite"):
        robot.run(0.01)
    robot.reset()
    (cube,) = engine.object_states()
    assert cube.position == pytest.approx(xyz)
    assert not any((*cube.linear, *cube.angular))
    robot.delete("cube")


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
