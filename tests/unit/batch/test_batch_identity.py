"""Each copy behaves as a single bring-up with the same commands, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from batch_rig import Beside, block_between

import tool0
from tool0.scene import Scene

pytestmark = pytest.mark.slow

HOME = tool0.DescriptionConfig()
SLIDING = tool0.DescriptionConfig(arm="ur10e", gripper="hande")
CELL = tool0.DescriptionConfig(robots=["left=ur5+2f85@0,0.5,0", "right=ur3e@0,-0.5,0"])


def around(beside: Beside, spread: float, seed: int) -> np.ndarray:
    """Return random targets near the present pose of the arms."""
    batch = beside.batch
    rng = np.random.default_rng(seed)
    columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
    q = batch.position[:, columns]
    return q + rng.uniform(-spread, spread, q.shape)


def tcp(description: tool0.DescriptionConfig) -> tool0.Transform:
    """Return the frame between the pads at the start."""
    with tool0.bringup(description=description, realtime=False) as robot:
        return robot.arm.pose() @ robot.gripper.tcp()


@pytest.mark.parametrize("description", [HOME, SLIDING], ids=["ur5", "ur10e"])
def test_gripping_and_lifting_a_block(description: tool0.DescriptionConfig) -> None:
    pads = tcp(description)
    scenes = [block_between(pads, mass) for mass in (0.05, 0.2, 0.4)]
    with Beside(3, description=description, scene=scenes) as beside:
        beside.run(0.02)
        beside.move_gripper([0.02, 0.02, 0.025], speed=[0.15, 0.12, 0.15])
        beside.run(0.8)
        beside.check()
        assert (beside.batch.pad_forces() > 5.0).all()
        low = beside.batch.object_position[:, 1, 2]
        up = around(beside, 0.0, 0)
        up[:, 1] -= 0.2
        beside.command(up, velocities=np.zeros_like(up), duration=0.4)
        beside.run(0.25)
        beside.check()
        beside.move_gripper([0.02, 0.045, 0.02], force=[60.0, 90.0, 75.0])
        beside.run(0.35)
        beside.check()
        rise = beside.batch.object_position[:, 1, 2] - low
        assert (rise[[0, 2]] > 0.05).all()


def test_commands_that_replace_each_other() -> None:
    with Beside(3, threads=2) as beside:
        for k in range(12):
            targets = around(beside, 0.15, k)
            kind = k % 3
            beside.command(
                targets,
                velocities=None if kind == 0 else 0.1 * (targets - targets.mean()),
                duration=(0.05, 0.031, 0.2)[kind],
                which=[0, 2] if k % 4 == 3 else None,
            )
            beside.run(0.05)
            beside.check()
        beside.run(0.3)
        beside.check()


def test_trajectories() -> None:
    with Beside(2) as beside:
        points = np.stack([around(beside, 0.2, seed) for seed in range(3)], axis=1)
        beside.follow(points, [0.2, 0.3, 0.5], np.zeros_like(points))
        beside.run(0.25)
        beside.check()
        beside.follow(points[:, ::-1], [0.1, 0.2, 0.4])
        beside.run(0.5)
        beside.check()


def test_resets_and_placements_of_some_copies() -> None:
    with Beside(3, scene="table_and_cubes") as beside:
        beside.command(around(beside, 0.3, 1), duration=0.3)
        beside.move_gripper([0.01, 0.04, 0.085])
        beside.run(0.15)
        beside.reset([0, 2], {"elbow_joint": 1.2})
        beside.run(0.02)
        beside.check()
        assert beside.batch.time.tolist() == [0.02, 0.17, 0.02]
        positions = np.array([[0.5, 0.2 + 0.1 * i, 0.3] for i in range(3)])
        beside.place("red cube", positions)
        beside.command(around(beside, 0.2, 2), duration=0.1)
        beside.run(0.2)
        beside.check()


def test_a_driven_joint_of_a_gripper_by_position() -> None:
    """Such a command lifts the limits of the grip before it."""
    with Beside(2) as beside:
        beside.move_gripper([0.02, 0.06], speed=[0.05, 0.1], force=[20.0, 100.0])
        beside.run(0.1)
        beside.command(np.array([[0.7], [0.1]]), duration=0.2, joints=["finger_joint"])
        beside.run(0.1)
        beside.check()
        beside.move_gripper([0.05, 0.05])
        beside.command(around(beside, 0.1, 3), duration=0.05)
        beside.run(1.2)
        beside.check()


def test_a_cell_with_two_robots() -> None:
    with Beside(2, description=CELL) as beside:
        assert len(beside.batch.arm_joints) == 12
        beside.command(around(beside, 0.2, 5), duration=0.2)
        beside.move_gripper([0.02, 0.06], gripper="left")
        beside.run(0.1)
        one = beside.batch.arm_joints[6:]
        targets = around(beside, 0.1, 6)[:, 6:]
        beside.command(targets, duration=0.1, joints=one)
        beside.run(0.2)
        beside.check()


def test_controllers_of_ros_2() -> None:
    """Their motions start where the copies are measured to be."""
    description = tool0.DescriptionConfig(ros2_control=True)
    with Beside(2, description=description) as beside:
        beside.command(around(beside, 0.2, 1), duration=0.2)
        beside.run(0.1)
        beside.check()
        points = np.stack([around(beside, 0.1, seed) for seed in range(2)], axis=1)
        beside.follow(points, [0.1, 0.2], np.zeros_like(points))
        beside.run(0.3)
        beside.check()


def test_a_gripper_action_controller() -> None:
    control = tool0.ControlConfig(gripper_action=True)
    with Beside(2, control=control) as beside:
        beside.move_gripper([0.02, 0.06], speed=[0.1, 0.05], force=[30.0, 100.0])
        beside.command(around(beside, 0.1, 7), duration=0.2)
        beside.run(0.05)
        beside.check()
        beside.move_gripper([0.06, 0.01], force=[60.0, 20.0])
        beside.move_gripper([0.05, 0.02])
        beside.run(0.5)
        beside.check()
        beside.reset([1])
        beside.move_gripper([0.04, 0.08], speed=[0.1, 0.15])
        beside.run(0.1)
        beside.check()


@pytest.mark.parametrize("has_goal_ended", [False, True])
def test_a_gripper_action_that_squeezes(has_goal_ended: bool) -> None:
    """A goal that stalls on a block ends, and the next one squeezes on."""
    pads = tcp(HOME)
    control = tool0.ControlConfig(gripper_action=True)
    with Beside(1, control=control, scene=[block_between(pads, 0.1)]) as beside:
        beside.move_gripper([0.0], force=[30.0])
        beside.run(1.9 if has_goal_ended else 0.6)
        beside.check()
        assert (beside.batch.pad_forces() > 5.0).all()
        beside.move_gripper([0.005], force=[80.0])
        beside.run(0.1)
        beside.check()


def test_a_longer_control_period_and_another_step() -> None:
    control = tool0.ControlConfig(control_period=0.004)
    with Beside(2, control=control, dt=0.002) as beside:
        beside.command(around(beside, 0.1, 8), duration=0.1)
        beside.move_gripper([0.03, 0.05])
        beside.run(0.3)
        beside.check()


def test_any_number_of_threads_gives_the_same() -> None:
    ends = []
    for threads in (1, 2, 5):
        with tool0.Batch(5, scene="table_and_cubes", threads=threads) as batch:
            targets = np.random.default_rng(9).uniform(-0.2, 0.2, (5, 6))
            columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
            batch.command(batch.position[:, columns] + targets, duration=0.2)
            batch.move_gripper(np.linspace(0.0, 0.08, 5))
            batch.run(0.3)
            ends.append((batch.position, batch.object_position))
    for position, objects in ends[1:]:
        assert np.array_equal(position, ends[0][0])
        assert np.array_equal(objects, ends[0][1])


def test_masses_and_frictions_are_as_if_compiled() -> None:
    pads = tcp(HOME)
    masses, frictions = (0.03, 0.5), (0.2, 0.7)
    made = [
        block_between(pads, mass, friction)
        for mass, friction in zip(masses, frictions, strict=True)
    ]

    def squeezed(scene: Scene | list[Scene], *, changes: bool) -> np.ndarray:
        with tool0.Batch(2, scene=scene) as batch:
            if changes:
                batch.set_mass("block", masses)
                batch.set_friction("block", frictions)
            batch.move_gripper(0.02, force=30.0)
            batch.run(0.6)
            columns = [batch.joint_names.index(j) for j in batch.arm_joints]
            q = batch.position[:, columns]
            batch.command(q - [0, 0.2, 0, 0, 0, 0], duration=0.4)
            batch.run(0.4)
            return np.hstack([batch.position, batch.object_position.reshape(2, -1)])

    compiled = squeezed(made, changes=False)
    changed = squeezed(block_between(pads, 0.1), changes=True)
    assert np.array_equal(compiled, changed)
    assert not np.array_equal(compiled[0], compiled[1])


def test_steps_of_some_copies() -> None:
    """Time stands still in the others, which then do as those did."""
    with tool0.Batch(3, description=HOME, scene="table_and_cubes") as batch:
        names = batch.arm_joints
        q = batch.position[:, [batch.joint_names.index(name) for name in names]]
        batch.command(q + 0.2, duration=0.1)
        start = batch.position
        batch.step(40, which=[1])
        batch.step(15, which=[False, True, False])
        assert batch.time == pytest.approx([0.0, 0.055, 0.0])
        assert (batch.position[[0, 2]] == start[[0, 2]]).all()
        assert (batch.position[1] != start[1]).any()
        batch.step(55, which=np.array([0, 2]))
        assert batch.time == pytest.approx([0.055] * 3)
        for row in (batch.position, batch.velocity, batch.object_position):
            assert (row == row[0]).all()
        batch.step(5, which=[])
        assert batch.time == pytest.approx([0.055] * 3)
