"""The cheat: what is gripped is fixed to the gripper until it opens."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM, BETWEEN_PADS, EDGE, HOME, TABLE, point

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ConfigError
from tool0.sensing.grasp import WARNING

SLIPPERY = Scene(
    (
        TABLE,
        SceneObject(
            name="soap",
            geometry=Box(size=(EDGE, EDGE, EDGE)),
            pose=Pose(xyz=BETWEEN_PADS),
            mass=0.5,
            friction=0.02,
        ),
    )
)


def grip_and_lift(robot: tool0.Robot) -> None:
    robot.gripper.move(opening=0.0, force=40.0)
    robot.run(1.0)
    robot.controller(ARM).follow([point(HOME, 2.0)]).wait(10.0)
    robot.run(0.5)


def height(robot: tool0.Robot) -> float:
    return robot.scene.pose("soap").position[2] - BETWEEN_PADS[2]


def on_tool(robot: tool0.Robot) -> np.ndarray:
    return np.subtract(robot.scene.pose("soap").position, robot.pose("tool0").position)


def test_what_is_too_slippery_is_lifted_and_falls_when_let_go(
    bring_up: BringUp, caplog: pytest.LogCaptureFixture
) -> None:
    """Without grasp assist it stays behind: ``test_objects.py``."""
    with caplog.at_level(logging.WARNING):
        robot = bring_up(scene=SLIPPERY, initial_pose="ready", grasp_assist=True)
    assert [r.message for r in caplog.records if r.message == WARNING]
    assert robot.info.grasp_assist
    grip_and_lift(robot)
    assert height(robot) > 0.2
    held = on_tool(robot)
    robot.run(0.5)
    np.testing.assert_allclose(on_tool(robot), held, atol=1e-3)
    robot.gripper.move(opening=0.085)
    robot.run(0.6)
    assert height(robot) < 0.05
    robot.reset()
    grip_and_lift(robot)
    assert height(robot) > 0.2
    robot.reset()  # lets go, too
    assert height(robot) == pytest.approx(0.0, abs=1e-6)
    robot.controller(ARM).move({"shoulder_lift_joint": -1.5}).wait(10.0)
    assert height(robot) == pytest.approx(0.0, abs=1e-3)


def test_without_a_gripper_it_is_refused(bring_up: BringUp) -> None:
    with pytest.raises(ConfigError):
        bring_up(gripper=None, grasp_assist=True)
