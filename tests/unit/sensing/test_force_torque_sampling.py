"""When a wrist's sensor samples, which links have one, and who may wait for it."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest
from ur5_rig import ARM, TWO_ROBOTS

import tool0
from tool0.errors import ControlError, ModelError
from tool0.sensing.force_torque import READINGS_KEPT

pytestmark = pytest.mark.slow

WEIGHT = 0.921 * 9.81  # [N] of the gripper


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


@pytest.mark.parametrize(
    ("control_period", "rate"), [(0.001, 125.0), (0.005, 100.0), (0.02, 50.0)]
)
def test_the_usual_rate_is_a_whole_part_of_the_control_rate(
    control_period: float, rate: float
) -> None:
    with tool0.bringup(
        realtime=False, control=tool0.ControlConfig(control_period=control_period)
    ) as robot:
        first = robot.force_torque.read()
        assert robot.force_torque.rate == pytest.approx(rate)
        robot.run(0.2)
        later = robot.force_torque.samples(since=first.number)
    steps = np.diff([reading.time for reading in (first, *later)])
    np.testing.assert_allclose(steps, 1.0 / rate)


def test_the_rate_fits_the_ticks() -> None:
    with tool0.bringup(
        realtime=False, control=tool0.ControlConfig(control_period=0.004)
    ) as robot:
        robot.force_torque.start(rate=250.0)
        with pytest.raises(ControlError) as error:
            robot.force_torque.start(rate=1000.0)
        assert str(error.value).endswith("250 Hz")  # the nearest possible one
        assert robot.force_torque.rate == 250.0  # what was goes on


def test_a_sample_is_the_same_however_often_one_samples() -> None:
    fast, slow = (
        tool0.bringup(realtime=False, control=tool0.ControlConfig(control_period=0.002))
        for _ in range(2)
    )
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


def test_samples_that_are_no_longer_kept_are_counted(robot: tool0.Robot) -> None:
    sensor = robot.force_torque
    sensor.start(rate=1000.0)
    robot.run(0.01)
    first = sensor.samples()
    assert [reading.number for reading in first] == list(range(11))
    assert not any(reading.dropped for reading in first)
    robot.run((READINGS_KEPT + 20) * 0.001)
    later = sensor.samples(since=first[-1].number)
    assert len(later) == READINGS_KEPT
    assert later[0].dropped == 20
    assert not any(reading.dropped for reading in later[1:])
    assert sensor.samples()[0].dropped == 31  # of all since the start


def test_whoever_waits_for_a_sample_is_woken(robot: tool0.Robot) -> None:
    sensor = robot.force_torque
    first = sensor.read()
    found: list[object] = []
    waiting = threading.Thread(
        target=lambda: found.extend(sensor.samples(first.number, timeout=30.0))
    )
    waiting.start()
    robot.run(0.02)
    waiting.join(30.0)
    assert found
    assert sensor.samples(sensor.read().number, timeout=0.01) == ()


def test_whoever_waits_hears_that_it_is_over_and_of_a_new_start() -> None:
    robot = tool0.bringup(realtime=False)
    sensor = robot.force_torque
    sensor.start()
    robot.run(0.1)
    old = sensor.read().number
    sensor.start()
    assert [reading.number for reading in sensor.samples(old)] == [0]
    robot.close()
    with pytest.raises(ControlError):
        sensor.samples(0, timeout=None)


def test_a_prefix_is_part_of_the_name() -> None:
    with tool0.bringup(realtime=False, prefix="left_") as robot:
        assert robot.force_torque.read().frame == "left_tool0"
        assert robot.force_torque_of("left_tool0").rate == robot.force_torque.rate > 0.0


def test_any_link_has_one_and_each_its_own_zero(robot: tool0.Robot) -> None:
    wrist = robot.force_torque_of("wrist_3_link")
    robot.force_torque.zero()
    heavier = float(np.linalg.norm(wrist.read().force))
    assert heavier == pytest.approx(WEIGHT + 0.1879 * 9.81, rel=0.01)
    assert robot.force_torque.read().force == (0.0, 0.0, 0.0)


def test_without_one_tool0_a_link_is_to_be_named() -> None:
    with tool0.bringup(realtime=False, robot=TWO_ROBOTS) as robot:
        with pytest.raises(ControlError) as error:
            robot.force_torque  # noqa: B018  # the property refuses
        for link in ("left_tool0", "right_tool0"):
            assert link in str(error.value)
        assert robot.force_torque_of("left_tool0").read().frame == "left_tool0"


def test_filtered_is_calmer_than_raw(robot: tool0.Robot) -> None:
    robot.force_torque.start(rate=500.0, cutoff=10.0)
    for opening in (0.0, 0.085, 0.02):
        robot.gripper.move(opening=opening)
        robot.run(0.5)
    readings = robot.force_torque.samples()
    assert len(readings) == 751
    raw = np.diff([reading.raw_force for reading in readings], axis=0)
    filtered = np.diff([reading.force for reading in readings], axis=0)
    assert np.abs(filtered).max() < 0.2 * np.abs(raw).max()


def test_samples_come_at_their_rate_and_stand_still_with_time(
    robot: tool0.Robot,
) -> None:
    first = robot.force_torque.read()
    assert robot.force_torque.rate == 125.0
    robot.run(0.1)
    readings = robot.force_torque.samples(since=first.number)
    times = [reading.time for reading in readings]
    np.testing.assert_allclose(times, 0.008 * np.arange(1, 13))
    robot.pause()
    assert robot.force_torque.samples(since=readings[-1].number) == ()
    robot.step(8)
    assert len(robot.force_torque.samples(since=readings[-1].number)) == 1
    robot.force_torque.stop()
    robot.force_torque.stop()
    assert robot.force_torque.rate == 0.0


def test_what_cannot_be_sampled_is_refused(robot: tool0.Robot) -> None:
    for rate, cutoff, values in (
        (20.0, 15.0, ("20 Hz", "[50, 1000] Hz")),
        (300.0, 15.0, ("300 Hz", "333.333 Hz")),
        (100.0, 60.0, ("60 Hz", "50 Hz")),
    ):
        with pytest.raises(ControlError) as error:
            robot.force_torque.start(rate=rate, cutoff=cutoff)
        for value in values:
            assert value in str(error.value)
    with pytest.raises(ModelError) as unknown:
        robot.force_torque_of("wrist_3_lnk")
    assert "'wrist_3_link'" in str(unknown.value)
