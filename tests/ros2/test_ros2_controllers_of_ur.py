"""The controllers of UR's driver that let the arm move by itself."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from ros import Bringup
from ros2_client import Client, Topic
from ros2_manager import Manager
from ros2_rig import (
    GOAL_VIOLATED,
    JTC,
    LOG,
    SUCCESSFUL,
    follow,
    tolerance,
    trajectory,
)
from ur5_rig import ARM_JOINTS
from waits import until

OPTIONS = ("--arm", "ur5e")
PASSTHROUGH = "passthrough_trajectory_controller"


@pytest.fixture(scope="module")
def manager(client: Client, bringup: Bringup) -> Manager:
    return Manager(client)


@pytest.fixture(scope="module")
def joints(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening("/joint_states", "sensor_msgs/msg/JointState") as topic:
        yield topic


@pytest.fixture(scope="module")
def log(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening("/rosout", LOG, wait=False) as log:
        yield log


@pytest.fixture
def passthrough(manager: Manager) -> Iterator[None]:
    """Have it in place of the trajectory controller."""
    assert not manager.switch([PASSTHROUGH])  # both claim the joints
    assert manager.switch([PASSTHROUGH], [JTC])
    yield
    assert manager.switch([JTC], [PASSTHROUGH])


def place(joints: Topic) -> np.ndarray:
    """Return where the arm is now [rad]."""
    (state,) = joints.next()
    position = dict(zip(state.name, state.position, strict=True))
    return np.array([position[name] for name in ARM_JOINTS])


def refused(client: Client, log: Topic, words: str, **goal: object) -> bool:
    """Return whether a goal has no result, and its reason is in the log."""
    since = log.count
    if client.send(
        f"/{PASSTHROUGH}/follow_joint_trajectory",
        "control_msgs/action/FollowJointTrajectory",
        goal,
    ).is_accepted:
        return False
    log.wait_for(
        lambda line: PASSTHROUGH in line.name and words in line.msg, since=since
    )
    return True


@pytest.mark.usefixtures("passthrough")
def test_points_are_executed_as_splines(client: Client, joints: Topic) -> None:
    start = place(joints)
    points = [(0.4, start + 0.1), (0.8, start)]
    for at_rest in (True, False):
        goal = follow(client, trajectory(points, at_rest=at_rest), PASSTHROUGH)
        status, result = goal.outcome()
        assert (status, result.error_code) == ("succeeded", SUCCESSFUL)
        assert result.error_string.startswith("Trajectory executed successfully in 0.8")
    until(lambda: np.allclose(place(joints), start, atol=5e-3), "the arm at its end")


@pytest.mark.usefixtures("passthrough")
def test_what_upstream_refuses_is_refused(
    client: Client, joints: Topic, log: Topic
) -> None:
    start = place(joints)
    whole = trajectory([(0.5, start)])
    mixed = trajectory([(0.5, start), (1.0, start)])
    mixed["points"][1]["velocities"] = []  # type: ignore[index]
    for words, goal in {
        "must have positions": {"trajectory": trajectory([(0.5, start[:5])])},
        "Point nr 2 has: 0 velocities": {"trajectory": mixed},
        "not known to this controller": {
            "trajectory": whole,
            "goal_tolerance": [tolerance("elbow", 0.1)],
        },
        "This controller knows 6 joints": {
            "trajectory": whole,
            "goal_tolerance": [tolerance("elbow_joint", 0.1)],
        },
        "rad from where": {"trajectory": trajectory([(0.0, start + 1.0)])},
    }.items():
        assert refused(client, log, words, **goal), words


@pytest.mark.usefixtures("passthrough")
def test_one_goal_at_a_time_and_a_cancel_stops_the_arm(
    client: Client, joints: Topic, log: Topic
) -> None:
    start = place(joints)
    goal = follow(client, trajectory([(4.0, start + 0.8)]), PASSTHROUGH)
    until(lambda: bool(place(joints)[0] > start[0] + 0.02), "motion")
    other = trajectory([(1.0, start)])
    assert refused(client, log, "already executing", trajectory=other)
    goal.cancel()
    assert goal.outcome()[0] == "canceled"
    until(lambda: max(map(abs, joints.next()[0].velocity)) < 0.005, "rest")
    assert place(joints)[0] < start[0] + 0.7
    back = follow(client, trajectory([(1.0, start)]), PASSTHROUGH)
    assert back.outcome()[0] == "succeeded"


@pytest.mark.usefixtures("passthrough")
def test_tolerances_of_the_goal_count_at_its_end(client: Client, joints: Topic) -> None:
    start = place(joints)
    goal = follow(
        client,
        trajectory([(0.1, start + 0.8)]),  # too fast for the arm
        PASSTHROUGH,
        goal_tolerance=[tolerance(name, 0.01) for name in ARM_JOINTS],
    )
    status, result = goal.outcome()
    assert (status, result.error_code) == ("aborted", GOAL_VIOLATED)
    assert "Robot not within tolerances at end" in result.error_string
    back = follow(client, trajectory([(1.5, start)]), PASSTHROUGH)
    assert back.outcome()[0] == "succeeded"


def test_deactivation_aborts_the_goal(
    client: Client, manager: Manager, joints: Topic
) -> None:
    assert manager.switch([PASSTHROUGH], [JTC])
    goal = follow(client, trajectory([(3.0, place(joints) + 0.3)]), PASSTHROUGH)
    assert goal.is_accepted
    assert manager.switch([JTC], [PASSTHROUGH])
    status, result = goal.outcome()
    assert status == "aborted"
    assert "controller is being deactivated" in result.error_string
