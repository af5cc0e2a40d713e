from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from raises_naming import raises_naming

import tool0
from tool0.description.loading import assemble
from tool0.errors import ConfigError
from tool0.scene import Box

pytestmark = pytest.mark.slow

LINKAGE = assemble(gripper_model="linkage")
FINGERS = [
    joint
    for joint in LINKAGE.model.movable_joints
    if "finger" in joint.name or "knuckle" in joint.name
]
DOWNWARDS = {
    "shoulder_lift_joint": -1.3,
    "elbow_joint": 1.7,
    "wrist_1_joint": -1.9708,
    "wrist_2_joint": -1.5708,
}
PADS = ("left_inner_finger_pad", "right_inner_finger_pad")


def bring_up(**options: object) -> tool0.Robot:
    linkage = tool0.DescriptionConfig(gripper_model="linkage")
    return tool0.bringup(description=linkage, realtime=False, **options)  # type: ignore[arg-type]


def departure(robot: tool0.Robot) -> float:
    """Return how far the fingers are from where they rest by themselves [rad]."""
    position = robot.joint_state.position
    return max(
        abs(position[joint.name] - joint.mimic.multiplier * position["finger_joint"])
        for joint in FINGERS
        if joint.mimic is not None
    )


@pytest.mark.parametrize(
    ("pose", "opening"), [("open", 0.085), ("half", 0.0425), ("closed", 0.0)]
)
def test_it_starts_and_rests_with_its_loops_closed(pose: str, opening: float) -> None:
    with bring_up(initial_pose=pose) as robot:
        assert len(FINGERS) == 8
        assert departure(robot) == 0.0
        robot.run(0.05)
        assert departure(robot) <= 2e-3
        robot.gripper.move(opening=opening)
        robot.run(1.5)
        squares = []
        for _ in range(200):
            robot.run(0.005)
            velocity = robot.joint_state.velocity
            squares.append([velocity[joint.name] ** 2 for joint in FINGERS])
        assert np.sqrt(np.mean(squares, axis=0)).max() <= 1e-4
        assert departure(robot) <= 2e-3
        assert robot.gripper.opening == pytest.approx(opening, abs=1e-3)
        robot.reset({"finger_joint": 0.3})
        assert departure(robot) == 0.0
        robot.run(0.1)
        assert departure(robot) <= 2e-3


def test_it_holds_two_kilograms_still() -> None:
    with bring_up(initial_pose=DOWNWARDS) as robot:
        robot.gripper.move(opening=0.05).wait(5.0)
        left, right = (np.array(robot.pose(pad).position) for pad in PADS)
        x, y, z = (left + right) / 2
        across = right - left
        yaw = float(np.arctan2(across[1], across[0]))
        edge = 0.045
        robot.scene.add(
            "stand", Box(size=(0.02, 0.02, 0.02)), xyz=(x, y, z - edge / 2 - 0.01)
        )
        robot.scene.add(
            "load", Box(size=(edge,) * 3), xyz=(x, y, z), rpy=(0, 0, yaw), mass=2.0
        )
        robot.gripper.move(opening=0.0, force=235.0)
        robot.run(1.5)
        for goal in robot.move_joints({"shoulder_lift_joint": -1.45}, speed=0.2):
            assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
        robot.run(1.0)
        start = held_at(robot)
        for _ in range(5):
            robot.run(1.0)
            assert np.linalg.norm(held_at(robot) - start) <= 1e-4
        assert robot.scene.pose("load").position[2] > z + 0.05


def held_at(robot: tool0.Robot) -> NDArray[np.float64]:
    """Return where the load is in the hand."""
    T_root_pad = robot.pose(PADS[0])
    return np.array(T_root_pad.inverse().apply(robot.scene.pose("load").position))


def test_a_robot_of_one_s_own_brings_its_own_gripper(tmp_path: Path) -> None:
    path = tmp_path / "own.urdf"
    path.write_text(LINKAGE.urdf)
    with raises_naming(ConfigError, "gripper_model"):
        bring_up(robot=path)
    with tool0.bringup(robot=path, realtime=False) as robot:
        robot.run(0.1)
        assert len(robot.description.model.loops) == 2
        assert departure(robot) <= 2e-3
