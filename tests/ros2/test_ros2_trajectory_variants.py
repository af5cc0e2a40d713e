"""JointTrajectoryController with other parameters, loaded as the spawner does."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from ros import Bringup
from ros2_client import Client, Topic
from ros2_manager import Manager
from ros2_rig import (
    JTC,
    REACHED,
    STATE,
    TRAJECTORY,
    arrive,
    come_to_rest,
    follow,
    go,
    tolerance,
    trajectory,
    wait_until_moving,
)
from ur5_rig import ARM_JOINTS, AWAY, HOME

FILE = Path(__file__).parent.parent / "data" / "controllers" / "ros2_variants.yaml"
NEAR = tuple(q + 0.2 for q in HOME)
SHIFT = 0.2
PAN, _, ELBOW = ARM_JOINTS[:3]


@pytest.fixture(scope="module")
def manager(client: Client, bringup: Bringup) -> Manager:
    return Manager(client)


@pytest.fixture(scope="module")
def home(client: Client, bringup: Bringup) -> None:
    """Have the arm at HOME before the first of these controllers."""
    with client.listening(f"/{JTC}/controller_state", STATE) as states:
        go(client, states, HOME)


@contextlib.contextmanager
def running(client: Client, manager: Manager, controller: str) -> Iterator[Topic]:
    """Have a controller of the file in place of the robot's own; yield its states."""
    manager.spawn(controller, FILE)
    assert manager.switch([controller], [JTC])
    try:
        with client.listening(f"/{controller}/controller_state", STATE) as states:
            go(client, states, HOME, controller)
            yield states
    finally:
        assert manager.switch([JTC], [controller])
        manager.unspawn(controller)


def references(states: Topic, since: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times [s] and references of the pan joint [rad]."""
    received = states.since(since)
    return (
        np.array([one.header.stamp for one in received]),
        np.array([one.reference.positions[0] for one in received]),
    )


def test_jazzy_replaces_at_once_also_by_a_trajectory_of_the_future(
    client: Client, manager: Manager, home: None
) -> None:
    name = "jazzy_controller"
    with running(client, manager, name) as states:
        follow(client, trajectory([(6.0, AWAY)]), name)
        wait_until_moving(states, 0.05)
        since = states.count
        stamp = states.last.header.stamp + 1.0
        second = follow(client, trajectory([(1.0, HOME)], stamp=stamp), name)
        assert second.outcome()[0] == "succeeded"
        arrive(states, HOME)
        _, pan = references(states, since)
        assert pan.max() - pan[0] < 0.05  # it goes on to AWAY no more


def test_jazzy_holds_joints_that_a_partial_goal_leaves_out(
    client: Client, manager: Manager, home: None
) -> None:
    name = "jazzy_controller"
    with running(client, manager, name) as states:
        follow(client, trajectory([(3.0, AWAY)]), name)
        wait_until_moving(states, 0.1)
        alone = trajectory([(0.6, [HOME[2]])], [ELBOW])
        goal = follow(client, alone, name)
        assert goal.outcome()[0] == "succeeded"
        rest = come_to_rest(states)
        assert abs(rest.feedback.positions[0] - AWAY[0]) > 0.2
        assert rest.feedback.positions[2] == pytest.approx(HOME[2], abs=0.01)


def test_by_default_joints_that_a_partial_goal_leaves_out_go_on(
    client: Client, manager: Manager, home: None
) -> None:
    """As in ROS, only in a trajectory of several points."""
    name = "desired_controller"
    with running(client, manager, name) as states:
        between = tuple(q + SHIFT / 2 for q in HOME)
        follow(client, trajectory([(0.7, between), (1.5, NEAR)]), name)
        wait_until_moving(states, 0.1)
        follow(client, trajectory([(2.5, [HOME[2]])], [ELBOW]), name)
        place = (*NEAR[:2], HOME[2], *NEAR[3:])
        arrive(states, place)


def test_an_end_in_motion_is_accepted_where_a_parameter_allows_it(
    client: Client, manager: Manager, home: None
) -> None:
    name = "jazzy_controller"
    with running(client, manager, name):
        message = trajectory([(1.0, NEAR)])
        message["points"] = [
            {"positions": NEAR, "velocities": [0.05] * 6, "time_from_start": 1.0}
        ]
        assert follow(client, message, name).is_accepted


def test_without_interpolation_each_point_is_sent_as_it_is(
    client: Client, manager: Manager, home: None
) -> None:
    """As long as the motion to it would take; so the first one never is, as in ROS.

    A command timeout ends the wait for a goal that is missed.
    """
    name = "stepwise_controller"
    with running(client, manager, name) as states:
        since = states.count
        places = [tuple(q + 0.02 * k for q in HOME) for k in (1, 2, 3)]
        points = list(zip((0.4, 0.8, 1.2), places, strict=True))
        missed = [tolerance(PAN, 1e-13)]
        goal = follow(client, trajectory(points), name, goal_tolerance=missed)
        assert goal.outcome()[0] == "aborted"
        times, pan = references(states, since)
        assert {round(float(value), 2) for value in pan[:-1]} == {0.0, 0.04, 0.06}
        begun = [times[np.argmax(pan > step)] for step in (0.02, 0.05)]
        assert np.diff(begun) == pytest.approx(0.4, abs=0.02)


def test_a_cancel_may_slow_down_instead(
    client: Client, manager: Manager, home: None
) -> None:
    name = "stopping_controller"
    with running(client, manager, name) as states:
        goal = follow(client, trajectory([(2.0, AWAY)]), name)
        wait_until_moving(states, 0.3)
        goal.cancel()
        since = states.count
        assert goal.outcome()[0] == "canceled"
        come_to_rest(states)
        received = states.since(since)
        speeds = np.array([one.feedback.velocities[0] for one in received])
        times = np.array([one.header.stamp for one in received])
        fast, slow = (np.argmax(speeds < limit) for limit in (0.25, 0.05))
        deceleration = 0.2 / (times[slow] - times[fast])
        assert deceleration == pytest.approx(1.0, rel=0.3)  # [rad/s²]


def test_positions_of_a_policy_become_a_smooth_spline(
    client: Client, manager: Manager, home: None
) -> None:
    name = "upsampling_controller"
    with running(client, manager, name) as states:
        since = states.count
        places = [tuple(q + SHIFT * k for q in HOME) for k in (0.25, 0.5, 0.75, 1.0)]
        message = trajectory([(0.0, one) for one in places], at_rest=False)
        client.publish(f"/{name}/joint_trajectory", TRAJECTORY, message)
        arrive(states, NEAR)
        received = states.since(since)
        times = np.array([one.header.stamp for one in received])
        speeds = np.array([one.reference.velocities[0] for one in received])
        jumps = np.abs(np.diff(speeds))
        assert jumps.max() < 0.1  # a cubic spline's: 5 rad/s² at most
        assert np.ptp(times[np.abs(speeds) > 1e-6]) == pytest.approx(0.8, abs=0.05)


def test_a_topic_scales_the_speed_where_no_interface_does(
    client: Client, manager: Manager, home: None
) -> None:
    name = "jazzy_controller"
    with running(client, manager, name) as states:
        client.publish(
            f"/{name}/speed_scaling_input",
            "control_msgs/msg/SpeedScalingFactor",
            {"factor": 0.5},
            latched=True,
        )
        states.wait_for_new(lambda state: state.speed_scaling_factor == 0.5)
        since = states.count
        goal = follow(client, trajectory([(0.6, NEAR)]), name)
        assert goal.outcome()[0] == "succeeded"
        moving = [
            state.header.stamp
            for state in states.since(since)
            if max(map(abs, state.reference.velocities)) > 1e-6
        ]
        assert moving[-1] - moving[0] == pytest.approx(1.2, abs=0.1)


def test_velocities_are_commanded_by_a_pid_on_the_position(
    client: Client, manager: Manager, home: None
) -> None:
    name = "velocity_controller"
    with running(client, manager, name) as states:
        claimed = manager.controllers()[name].claimed_interfaces
        assert set(claimed) == {f"{joint}/velocity" for joint in ARM_JOINTS}
        since = states.count
        status, result = follow(client, trajectory([(1.0, NEAR)]), name).outcome()
        assert (status, result.error_string) == ("succeeded", REACHED)
        arrive(states, NEAR)
        commanded = [one.output.velocities[0] for one in states.since(since)]
        assert max(commanded) == pytest.approx(1.5 * SHIFT, rel=0.1)


def test_a_forward_controller_takes_positions_from_its_topic(
    client: Client, manager: Manager, home: None
) -> None:
    name = "position_forwarder"
    kind = "std_msgs/msg/Float64MultiArray"
    manager.spawn(name, FILE)
    assert not manager.switch([name])  # its interfaces are claimed
    assert manager.switch([name], [JTC])
    try:
        with client.listening("/joint_states", "sensor_msgs/msg/JointState") as states:
            client.publish(f"/{name}/commands", kind, {"data": list(NEAR)})

            def is_there(state: object) -> bool:
                position = dict(zip(state.name, state.position, strict=True))
                return all(
                    abs(position[joint] - q) < 0.01
                    for joint, q in zip(ARM_JOINTS, NEAR, strict=True)
                )

            states.wait_for_new(is_there)
            client.publish(f"/{name}/commands", kind, {"data": [0.0]})  # ignored
            states.next(50)
            assert is_there(states.last)
    finally:
        assert manager.switch([JTC], [name])
        manager.unspawn(name)
