"""When a wrist's sensor samples, which links have one, and who may wait for it."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from ur5_rig import ARM, TWO_ROBOTS

import tool0
from tool0.errors import ControlError

WEIGHT = 0.921 * 9.81  # [N] of the gripper


@pytest.mark.parametrize(
    ("control_period", "rate"), [(0.001, 125.0), (0.005, 100.0), (0.02, 50.0)]
)
def test_the_usual_rate_is_a_whole_part_of_the_control_rate(
    control_period: float, rate: float
) -> None:
    with tool0.bringup(realtime=False, control_period=control_period) as robot:
        first = robot.force_torque.read()
        assert robot.force_torque.rate == pytest.approx(rate)
        robot.run(0.2)
        later = robot.force_torque.samples(since=first.number)
    steps = np.diff([reading.time for reading in (first, *later)])
    np.testing.assert_allclose(steps, 1.0 / rate)


def test_the_rate_fits_the_ticks() -> None:
    with tool0.bringup(realtime=False, control_period=0.004) as robot:
        robot.force_torque.start(rate=250.0)
        with pytest.raises(
            ControlError, match=r"250 Hz; the nearest that is is 250 Hz"
        ):
            robot.force_torque.start(rate=1000.0)
        assert robot.force_torque.rate == 250.0  # what was goes on


def test_a_sample_is_the_same_however_often_one_samples() -> None:
    fast, slow = (tool0.bringup(realtime=False, control_period=0.002) for _ in range(2))
    with fast, slow:
        fast.force_torque.start(rate=500.0)
        slow.force_torque.start(rate=50.0)
        for robot in (fast, slow):
            robot.controller(ARM).move({"elbow_joint": 1.0}, speed=1.0)
            robot.run(0.4)
        often = {r.time: r.raw_force for r in fast.force_torque.samples()}
        assert len(often) == 201
        for reading in slow.force_torque.samples():
            assert often[reading.time] == reading.raw_force


def test_whoever_waits_for_a_sample_is_woken() -> None:
    with tool0.bringup(realtime=False) as robot:
        first = robot.force_torque.read()
        found: list[object] = []
        waiting = threading.Thread(
            target=lambda: found.extend(
                robot.force_torque.samples(first.number, timeout=10.0)
            )
        )
        waiting.start()
        robot.run(0.02)
        waiting.join(10.0)
        assert found
        assert robot.force_torque.samples(99, timeout=0.01) == ()


def test_a_prefix_is_part_of_the_name() -> None:
    with tool0.bringup(realtime=False, prefix="left_") as robot:
        assert robot.force_torque.read().frame == "left_tool0"
        assert robot.force_torque is robot.force_torque_of("left_tool0")


def test_any_link_has_one_and_each_its_own_zero() -> None:
    with tool0.bringup(realtime=False) as robot:
        wrist = robot.force_torque_of("wrist_3_link")
        robot.force_torque.zero()
        heavier = float(np.linalg.norm(wrist.read().force))
        assert heavier == pytest.approx(WEIGHT + 0.1879 * 9.81, rel=0.01)
        assert robot.force_torque.read().force == (0.0, 0.0, 0.0)


def test_without_one_tool0_a_link_is_to_be_named() -> None:
    with tool0.bringup(realtime=False, robot=TWO_ROBOTS) as robot:
        with pytest.raises(
            ControlError, match=r"needs exactly one link 'tool0'.*: .*, "
        ):
            robot.force_torque  # noqa: B018  # the property refuses
        assert robot.force_torque_of("left_tool0").read().frame == "left_tool0"
