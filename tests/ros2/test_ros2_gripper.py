"""The gripper's controllers by rclpy: its action, and its activation."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from ros import Bringup
from ros2_client import Client, Goal, Topic
from ros2_rig import GRIPPER

ACTION = f"/{GRIPPER}/gripper_cmd"
KIND = "control_msgs/action/ParallelGripperCommand"
KNUCKLE = "finger_joint"
TOLERANCE = 0.02
"""Of the built-in controller [rad]."""


@pytest.fixture(scope="module")
def joint_states(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening("/joint_states", "sensor_msgs/msg/JointState") as states:
        yield states


def grip(client: Client, *position: float, **command: object) -> Goal:
    return client.send(
        ACTION, KIND, {"command": {"name": [KNUCKLE], "position": position, **command}}
    )


def knuckle(states: Topic) -> float:
    (state,) = states.next()
    angle: float = state.position[state.name.index(KNUCKLE)]
    return angle


def test_it_closes_and_opens(client: Client, joint_states: Topic) -> None:
    for angle in (0.4, 0.1):
        status, result = grip(client, angle).outcome()
        assert status == "succeeded"
        assert result.reached_goal
        assert not result.stalled
        assert result.state.position[0] == pytest.approx(angle, abs=0.02)
        assert knuckle(joint_states) == pytest.approx(angle, abs=0.03)


def test_the_result_agrees_with_its_flags(client: Client, joint_states: Topic) -> None:
    for k in range(12):
        angle = 0.2 + 0.1 * (k % 2)
        _, result = grip(client, angle).outcome()
        assert result.reached_goal
        assert abs(result.state.position[0] - angle) < TOLERANCE
        assert len(result.state.velocity) == 0  # it is not known for that instant


def test_exactly_one_position_is_a_goal(client: Client, joint_states: Topic) -> None:
    assert not grip(client).is_accepted
    assert not grip(client, 0.1, 0.2).is_accepted
    assert not grip(client, float("nan")).is_accepted


def test_a_slow_goal_can_be_cancelled_and_holds(
    client: Client, joint_states: Topic
) -> None:
    assert grip(client, 0.0).outcome()[0] == "succeeded"
    goal = grip(client, 0.7, velocity=[0.1])
    joint_states.wait_for_new(
        lambda state: state.position[state.name.index(KNUCKLE)] > 0.1
    )
    goal.cancel()
    assert goal.outcome()[0] == "canceled"
    held = knuckle(joint_states)
    joint_states.next(60)
    assert knuckle(joint_states) == pytest.approx(held, abs=0.03)
    assert held < 0.6


def test_it_is_activated_again_by_a_service(
    client: Client, joint_states: Topic
) -> None:
    answer = client.call(
        "/robotiq_activation_controller/reactivate_gripper", "std_srvs/srv/Trigger"
    )
    assert answer.success
    assert grip(client, 0.2).outcome()[0] == "succeeded"
