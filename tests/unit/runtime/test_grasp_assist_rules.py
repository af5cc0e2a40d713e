"""When the cheat holds on, and when it lets go."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import tool0
from tool0.description.model import Box, Pose
from tool0.description.scene import Scene, SceneObject

EDGE = 0.04  # [m]
BETWEEN_PADS = (0.5487, 0.1091, 0.003)
"""Where an object lies between the pads in the pose ``ready``, in the root [m]."""


def block(name: str, z: float, mass: float | None) -> SceneObject:
    x, y, _ = BETWEEN_PADS
    return SceneObject(
        name=name,
        geometry=Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=(x, y, z)),
        mass=mass,
    )


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    """A block on a post, gripped, and the post gone."""
    z = BETWEEN_PADS[2]
    scene = Scene((block("post", z - EDGE, None), block("soap", z, 0.2)))
    with tool0.bringup(
        realtime=False, scene=scene, initial_pose="ready", grasp_assist=True
    ) as robot:
        robot.gripper.move(opening=0.0, force=40.0)
        robot.run(1.0)
        robot.scene.remove("post")
        yield robot


def is_attached(robot: tool0.Robot) -> bool:
    robot.run(0.02)
    base = "robotiq_arg2f_base_link"
    return any({c.first, c.second} == {base, "soap"} for c in robot.contacts())


def test_it_holds_on_while_the_grip_changes(robot: tool0.Robot) -> None:
    assert is_attached(robot)
    robot.gripper.move(opening=0.0, force=200.0)
    robot.run(0.5)
    assert is_attached(robot)
    robot.emergency_stop()
    robot.run(0.2)
    robot.emergency_stop(False)
    robot.run(0.2)
    assert is_attached(robot)


def test_it_lets_go_as_soon_as_the_gripper_is_to_open(robot: tool0.Robot) -> None:
    robot.gripper.move(opening=0.05)
    robot.run(0.016)
    assert not is_attached(robot)


def test_it_takes_no_notice_of_what_is_taken_away(robot: tool0.Robot) -> None:
    robot.scene.remove("soap")
    robot.run(0.5)
    assert robot.gripper.opening < 0.5 * EDGE  # and nothing complained


def test_what_stands_fast_is_attached_to_nothing() -> None:
    post = block("soap", BETWEEN_PADS[2], None)
    with tool0.bringup(
        realtime=False, scene=Scene((post,)), initial_pose="ready", grasp_assist=True
    ) as robot:
        robot.gripper.move(opening=0.0, force=40.0)
        robot.run(1.0)
        assert robot.gripper.state.motion == "holding_inside"
        assert not is_attached(robot)
