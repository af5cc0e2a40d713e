"""The wrench of contacts on the tool."""

from __future__ import annotations

import numpy as np
import pytest
from batch_rig import block_between
from raises_naming import raises_naming

import tool0
from tool0.description.transform_arrays import from_quats
from tool0.errors import ControlError

WEIGHT = 9.80665
MASSES = (0.1, 0.4)


def test_it_is_the_weight_of_what_the_gripper_holds() -> None:
    with tool0.Batch(1) as empty:
        position, _ = empty.tcp_pose()
        assert (empty.tool_wrench() == 0.0).all()
    pads = tool0.Transform(position=tuple(position[0].tolist()))
    scenes = [block_between(pads, mass) for mass in MASSES]
    with tool0.Batch(2, scene=scenes) as batch:
        batch.move_gripper(0.02, force=60.0)
        batch.run(0.8)
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        up = batch.position[:, columns]
        up[:, 1] -= 0.2
        batch.command(up, velocities=np.zeros_like(up), duration=0.4)
        batch.run(1.4)
        force, torque = np.hsplit(batch.tool_wrench(), 2)
        tool, quat = batch.tool_pose()
        block = batch.object_position[:, batch.object_names.index("block")]
        for i, (mass, R) in enumerate(zip(MASSES, from_quats(quat), strict=True)):
            weight = R.T @ [0.0, 0.0, -WEIGHT * mass]
            lever = R.T @ (block[i] - tool[i])
            assert force[i] == pytest.approx(weight, abs=0.05 * WEIGHT * mass)
            assert torque[i] == pytest.approx(np.cross(lever, weight), abs=0.02)


def test_a_tool_that_presses_on_the_ground_is_pushed_back() -> None:
    with tool0.Batch(2, control=tool0.ControlConfig(initial_pose="ready")) as batch:
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        down = batch.position[:, columns] + [[0.0, 0.9, 0.0, 0.0, 0.0, 0.0], [0.0] * 6]
        batch.command(down, velocities=np.zeros_like(down), duration=1.0)
        batch.run(1.2)
        force = batch.tool_wrench()[:, :3]
        _, quat = batch.tool_pose()
        assert (from_quats(quat)[0] @ force[0])[2] > 20.0
        assert (force[1] == 0.0).all()


def test_the_arm_is_named_in_a_cell() -> None:
    cell = tool0.DescriptionConfig(
        robots=["left=ur5+2f85@0,0.5,0", "right=ur3e@0,-0.5,0"]
    )
    with tool0.Batch(1, description=cell) as batch:
        assert (batch.tool_wrench("right") == 0.0).all()
        with raises_naming(ControlError, "left", "right"):
            batch.tool_wrench()
