"""Tables of tool poses: the same as the poses of single postures."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.description.config import DescriptionConfig
from tool0.description.forward_kinematics import link_poses
from tool0.description.grasp_frames import flange_of, grasp_frame
from tool0.description.loading import assemble, load_description
from tool0.description.model import RobotModel
from tool0.description.parts import find_grippers
from tool0.description.tool_poses import ToolPoses

CELL = DescriptionConfig(robots=("left=ur5e+2f85", "right=ur3e+hande@1,0,0"))


def tools_of(model: RobotModel) -> ToolPoses:
    return ToolPoses(model, [joint.name for joint in model.movable_joints])


def random_positions(model: RobotModel, n: int) -> np.ndarray:
    rng = np.random.default_rng(seed=0)
    bounds = [
        (max(joint.limits.lower, -3.0), min(joint.limits.upper, 3.0))
        for joint in model.movable_joints
    ]
    return rng.uniform(*np.array(bounds).T, size=(n, len(bounds)))


@pytest.mark.parametrize("config", [CELL, DescriptionConfig()])
def test_each_row_is_the_pose_of_its_posture(config: DescriptionConfig) -> None:
    model = load_description(config).model
    positions = random_positions(model, 20)
    poses = tools_of(model).poses(positions)
    assert tuple(poses) == tools_of(model).names
    for k, row in enumerate(positions):
        joints = dict(
            zip((joint.name for joint in model.movable_joints), row, strict=True)
        )
        links = link_poses(model, joints)
        expected = {flange: links[flange] for flange in model.flanges}
        for name, gripper in find_grippers(model).items():
            flange = flange_of(model, gripper)
            opening = gripper.opening(joints[gripper.joint])
            opening = min(max(opening, 0.0), gripper.max_opening)
            T_flange_tcp = grasp_frame(model, gripper, opening, flange)
            expected[f"{name}.tcp"] = links[flange] @ T_flange_tcp
        assert poses.keys() == expected.keys()
        for name, pose in expected.items():
            np.testing.assert_allclose(poses[name][k, :3], pose.position, atol=1e-9)
            alike = abs(poses[name][k, 3:] @ pose.quat_wxyz)
            assert alike == pytest.approx(1.0, abs=1e-12)


def test_the_names_are_those_of_links_and_grippers() -> None:
    assert tools_of(load_description(CELL).model).names == (
        *("left_tool0", "right_tool0"),
        *("left.tcp", "right.tcp"),
    )
    assert tools_of(assemble("ur5", gripper="2f85").model).names == (
        *("tool0", "gripper.tcp"),
    )
    assert tools_of(assemble("ur5", gripper=None).model).names == ("tool0",)


def test_quaternions_do_not_change_their_sign_within_a_turn() -> None:
    model = assemble("ur5", gripper=None).model
    positions = np.zeros((200, 6))
    positions[:, 5] = np.linspace(-6.0, 6.0, 200)
    quat = tools_of(model).poses(positions)["tool0"][:, 3:]
    assert np.abs(np.diff(quat, axis=0)).max() < 0.1
    assert quat[:, 0].min() < 0.0 < quat[:, 0].max()


def test_there_may_be_no_samples() -> None:
    model = assemble("ur5", gripper="2f85").model
    poses = tools_of(model).poses(np.empty((0, len(model.movable_joints))))
    assert {pose.shape for pose in poses.values()} == {(0, 7)}
