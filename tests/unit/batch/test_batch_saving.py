"""Saved copies continue as they would have, to the bit, in any copy and batch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from raises_naming import raises_naming

import tool0
from tool0.errors import ControlError, EngineError
from tool0.scene import Box, Pose, Scene, SceneObject

BLOCK = SceneObject(
    name="block",
    geometry=Box(size=(0.05, 0.05, 0.05)),
    pose=Pose(xyz=(0.5, 0.2, 0.3)),
    mass=0.2,
)
SHELF = SceneObject(
    name="shelf", geometry=Box(size=(0.2, 0.2, 0.02)), pose=Pose(xyz=(0.5, 0.2, 0.1))
)
SCENE = Scene(objects=(BLOCK, SHELF))


def batch(n: int = 2, **options: Any) -> tool0.Batch:
    return tool0.Batch(n, scene=SCENE, threads=1, **options)


def seen(copies: tool0.Batch, row: int) -> tuple[bytes, ...]:
    """Return what one copy is measured to be, to the bit."""
    arrays = (
        copies.time,
        copies.position,
        copies.velocity,
        copies.effort,
        copies.object_position,
        copies.object_quat,
        copies.object_linear,
        copies.pad_forces(),
    )
    return tuple(values[row].tobytes() for values in arrays)


def disturb(copies: tool0.Batch) -> None:
    """Bring the copies into motion: arms, grippers, a block that falls on a shelf."""
    rest = copies.position[:, [copies.joint_names.index(j) for j in copies.arm_joints]]
    speeds = np.array([[0.3], [-0.2]])[: copies.n]
    copies.command(rest + speeds, velocities=0.0 * rest, duration=0.4)
    copies.move_gripper(0.02, speed=0.1, force=40.0)
    copies.set_mass("block", [0.1, 0.5][: copies.n])
    copies.set_friction("block", [0.5, 0.7][: copies.n])
    copies.place("shelf", [[0.5, 0.2, 0.15], [0.5, 0.22, 0.2]][: copies.n])
    copies.run(0.21)


def test_copies_continue_as_they_would_have() -> None:
    with batch() as copies:
        disturb(copies)
        state = copies.save()
        now = seen(copies, 0)
        copies.run(0.2)
        later = [seen(copies, i) for i in range(2)]
        copies.reset()
        copies.run(0.05)
        copies.restore(state)
        assert seen(copies, 0) == now
        copies.run(0.2)
        assert [seen(copies, i) for i in range(2)] == later
        copies.restore(state)
        copies.run(0.2)
        assert [seen(copies, i) for i in range(2)] == later


def test_a_copy_takes_the_state_of_another_one() -> None:
    with batch() as copies:
        disturb(copies)
        state = copies.save()
        copies.restore(state, which=[1], source=0)
        copies.run(0.2)
        assert seen(copies, 0) == seen(copies, 1)
        copies.restore(state, source=[1, 0])
        copies.run(0.2)
        swapped = [seen(copies, i) for i in range(2)]
        copies.restore(state)
        copies.run(0.2)
        assert swapped == [seen(copies, 1), seen(copies, 0)]
        assert swapped[0] != swapped[1]


def test_saving_changes_nothing() -> None:
    with batch() as copies, batch() as others:
        for each in (copies, others):
            disturb(each)
        copies.save()
        for each in (copies, others):
            each.run(0.1)
        assert seen(copies, 1) == seen(others, 1)


def test_another_batch_continues_with_the_state() -> None:
    with batch() as copies, batch(3) as others:
        disturb(copies)
        others.restore(copies.save(), source=[1, 1, 0])
        for each in (copies, others):
            each.command(each.position[:, :6], duration=0.1)
            each.run(0.1)
        assert seen(others, 0) == seen(copies, 1) == seen(others, 1)
        assert seen(others, 2) == seen(copies, 0)


def test_a_goal_of_a_gripper_is_named() -> None:
    control = tool0.ControlConfig(gripper_action=True)
    with batch(control=control) as copies:
        copies.save()
        copies.move_gripper(0.02)
        with raises_naming(ControlError, "gripper_controller", "goal"):
            copies.save()


def test_controllers_of_ros_2() -> None:
    description = tool0.DescriptionConfig(ros2_control=True)
    with batch(description=description) as copies:
        columns = [copies.joint_names.index(joint) for joint in copies.arm_joints]
        rest = copies.position[:, columns]
        turn = np.array([[0.3], [-0.2]])
        copies.command(rest + turn, velocities=0.0 * rest, duration=0.4)
        copies.run(0.21)
        state = copies.save()
        copies.run(0.3)
        later = seen(copies, 1)
        copies.restore(state)
        copies.run(0.3)
        assert seen(copies, 1) == later


def test_a_state_of_other_objects_or_copies_is_refused() -> None:
    with batch() as copies, tool0.Batch(1, threads=1) as bare:
        state = copies.save()
        with raises_naming(EngineError, "block", "shelf", "none"):
            bare.restore(state, source=0)
        with raises_naming(ControlError, "'source' names copy 2", "0 … 1"):
            copies.restore(state, source=[0, 2])
        with raises_naming(ControlError, "'source'", "(2,)"):
            copies.restore(state, source=[0, 1, 0])
        with raises_naming(ControlError, "'source' names copy 0.5"):
            copies.restore(state, source=0.5)


@pytest.mark.parametrize("method", ["save", "restore"])
def test_what_a_batch_on_a_device_says(method: str) -> None:
    pytest.importorskip("mujoco_warp")
    with tool0.Batch(1, device="warp:cpu") as copies:
        arguments = () if method == "save" else (None,)
        with raises_naming(ControlError, f"Batch.{method}", "device='cpu'"):
            getattr(copies, method)(*arguments)
