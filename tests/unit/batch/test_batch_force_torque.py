"""Force-torque sensors of copies: each measures as that of a single bring-up."""

from __future__ import annotations

import numpy as np
import pytest
from batch_rig import Beside, block_between
from numpy.typing import NDArray
from test_batch_identity import around, tcp

import tool0
from tool0.errors import ControlError, ModelError
from tool0.kernel import library

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
HOME = tool0.DescriptionConfig()


def check_wrenches(beside: Beside, link: str | None = None) -> Array:
    """Assert that every copy measures what its bring-up does; return the wrenches."""
    sensor = beside.batch.force_torque_of(link)
    found, raw = sensor.read(), sensor.read_raw()
    for i, robot in enumerate(beside.robots):
        reading = robot.force_torque_of(link).read()
        assert found[i].tolist() == [*reading.force, *reading.torque], i
        assert raw[i].tolist() == [*reading.raw_force, *reading.raw_torque], i
    return found


@pytest.mark.parametrize(
    ("description", "rate"),
    [
        (HOME, 125.0),
        (tool0.DescriptionConfig(arm="ur10e", gripper="hande"), 250.0),
        (tool0.DescriptionConfig(ros2_control=True), None),
    ],
    ids=["2f85", "sliding fingers", "ros 2"],
)
def test_they_measure_as_single_robots(
    description: tool0.DescriptionConfig, rate: float | None
) -> None:
    """In motion, with something in the gripper, and after resets and tares."""
    scenes = None  # with ROS 2, the gripper starts closed
    if not description.ros2_control:
        scenes = [block_between(tcp(description), mass) for mass in (0.1, 0.3)]
    with Beside(2, description=description, scene=scenes) as beside:
        batch = beside.batch
        beside.run(0.011)
        started = batch.force_torque.start(rate, cutoff=20.0)
        for robot in beside.robots:
            assert robot.force_torque.start(rate, cutoff=20.0) == started
        check_wrenches(beside)
        beside.move_gripper([0.02, 0.025], force=[60.0, 90.0])
        beside.run(0.5)
        check_wrenches(beside)
        batch.force_torque.zero()
        for robot in beside.robots:
            robot.force_torque.zero()
        up = around(beside, 0.0, 0)
        up[:, 1] -= 0.2
        beside.command(up, velocities=np.zeros_like(up), duration=0.3)
        for _ in range(4):
            beside.run(0.056)
            moving = check_wrenches(beside)
        assert np.abs(moving[:, :3]).max() > 0.5
        beside.reset([1])
        beside.run(0.1)
        check_wrenches(beside)
        beside.check()


def test_a_tool_that_presses_on_the_ground() -> None:
    control = tool0.ControlConfig(initial_pose="ready")
    with Beside(2, control=control) as beside:
        check_wrenches(beside)
        down = around(beside, 0.0, 0)
        down[0, 1] += 0.9
        beside.command(down, velocities=np.zeros_like(down), duration=1.0)
        beside.run(1.2)
        pressed, free = np.linalg.norm(check_wrenches(beside)[:, :3], axis=1)
        assert pressed > free + 20.0


def test_two_sensors_of_a_cell() -> None:
    cell = tool0.DescriptionConfig(
        robots=["left=ur5+2f85@0,0.5,0", "right=ur3e@0,-0.5,0"]
    )
    with Beside(1, description=cell) as beside:
        batch = beside.batch
        links = ("left_tool0", "right_tool0")
        for link, rate in zip(links, (125.0, 200.0), strict=True):
            batch.force_torque_of(link).start(rate)
            beside.robots[0].force_torque_of(link).start(rate)
        beside.command(around(beside, 0.2, 5), duration=0.2)
        beside.run(0.103)
        for link in links:
            check_wrenches(beside, link)
        with pytest.raises(ControlError, match="left_tool0"):
            _ = batch.force_torque


@pytest.mark.skipif(
    library.load() is None, reason="no compiled kernel in this installation"
)
def test_python_measures_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def measured() -> list[Array]:
        found = []
        with tool0.Batch(2, scene="table_and_cubes") as batch:
            batch.force_torque.start(500.0)
            columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
            q = batch.position[:, columns] + [[0.05], [0.02]]
            batch.command(q, duration=0.04)
            for ticks in (5, 1, 30):
                batch.step(ticks)
                batch.step(1, [1])  # its samples are due at other times then
                found += [batch.force_torque.read(), batch.force_torque.read_raw()]
        return found

    compiled = measured()
    monkeypatch.setenv(library.VARIABLE, "python")
    for one, other in zip(compiled, measured(), strict=True):
        assert np.array_equal(one, other)


def test_saved_states_have_the_filter_and_not_the_tare() -> None:
    with tool0.Batch(2) as batch:
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        batch.force_torque.start()
        batch.command(batch.position[:, columns] + 0.1, duration=0.1)
        batch.run(0.05)
        state = batch.save()
        batch.run(0.053)
        after = batch.force_torque.read()
        batch.restore(state)
        batch.run(0.053)
        assert np.array_equal(batch.force_torque.read(), after)
        batch.force_torque.zero(which=[0])
        assert (batch.force_torque.read()[0] == 0.0).all()
        batch.restore(state)
        batch.run(0.053)
        assert np.array_equal(batch.force_torque.read() + after * [[1], [0]], after)


def test_it_costs_nothing_before_the_start_and_after_the_stop() -> None:
    with tool0.Batch(1) as batch:
        assert batch.force_torque.rate == 0.0
        assert batch.force_torque_of("tool0") is batch.force_torque
        first = batch.force_torque.read()
        assert batch.force_torque.rate == 125.0
        batch.force_torque.stop()
        batch.force_torque.stop()
        assert batch.force_torque.rate == 0.0
        assert np.array_equal(batch.force_torque.read(), first)
        with pytest.raises(ControlError, match="nearest rate"):
            batch.force_torque.start(99.0)
        with pytest.raises(ModelError, match="nowhere"):
            batch.force_torque_of("nowhere")
