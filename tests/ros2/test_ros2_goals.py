"""JointTrajectoryController by rclpy's action client, at the defaults of the robot."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pytest
from ros import Bringup
from ros2_client import Client, Message, Topic
from ros2_manager import Manager
from ros2_rig import (
    GOAL_VIOLATED,
    INVALID_GOAL,
    JTC,
    LOG,
    PATH_VIOLATED,
    REACHED,
    STATE,
    SUCCESSFUL,
    TRAJECTORY,
    arrive,
    come_to_rest,
    distance,
    follow,
    go,
    tolerance,
    trajectory,
    wait_until_moving,
)
from ur5_rig import ARM_JOINTS, AWAY, HOME
from waits import until

ENGINES = ("mujoco", "gazebo")
NEAR = tuple(q + 0.2 for q in HOME)
SHIFT = np.subtract(NEAR, HOME)
PAN, LIFT, ELBOW = ARM_JOINTS[:3]
FAR = (HOME[0] + 1.5, *HOME[1:])
"""Too far to be reached in a tenth of a second."""

in_mujoco = pytest.mark.parametrize("bringup", ["mujoco"], indirect=True)
"""For what does not depend on the physics."""


@pytest.fixture(scope="module")
def states(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening(f"/{JTC}/controller_state", STATE) as states:
        yield states


@pytest.fixture(scope="module")
def log(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening("/rosout", LOG, wait=False) as log:
        yield log


@pytest.fixture(scope="module")
def manager(client: Client, bringup: Bringup) -> Manager:
    return Manager(client)


@pytest.fixture
def at_home(client: Client, states: Topic) -> None:
    """Have the arm at HOME, at rest."""
    go(client, states, HOME)


def logged(log: Topic, since: int, *words: str) -> None:
    """Wait for an error or a warning of the controller that has all ``words``."""
    log.wait_for(
        lambda line: (
            line.level >= 30 and JTC in line.name and all(w in line.msg for w in words)
        ),
        since=since,
        timeout=10.0,
    )


def test_a_goal_succeeds_and_the_arm_is_there(
    client: Client, at_home: None, states: Topic
) -> None:
    goal = follow(client, trajectory([(0.6, NEAR), (1.2, HOME), (2.0, NEAR)]))
    assert goal.is_accepted
    start = time.monotonic()
    status, result = goal.outcome()
    elapsed = time.monotonic() - start
    assert (status, result.error_code) == ("succeeded", SUCCESSFUL)
    assert result.error_string == REACHED
    arrive(states, NEAR)
    feedback = goal.feedback()
    # action_monitor_rate, of wall time: a busy machine is late now and then.
    assert 12.0 * elapsed < len(feedback) < 20.0 * elapsed + 2
    for one in feedback:
        assert tuple(one.joint_names) == ARM_JOINTS
        np.testing.assert_allclose(
            np.subtract(one.desired.positions, one.actual.positions),
            one.error.positions,
            atol=1e-12,
        )
        assert len(one.actual.velocities) == len(one.desired.accelerations) == 6
    indices = [one.index for one in feedback]
    assert indices == sorted(indices)
    assert set(indices) >= {0, 1, 2}


@in_mujoco
def test_a_point_is_approached_from_the_measured_state(
    client: Client, at_home: None, states: Topic
) -> None:
    """In one motion, with the command a period ahead of the reference."""
    since = states.count
    assert follow(client, trajectory([(1.0, NEAR)])).outcome()[0] == "succeeded"
    received = states.since(since)
    reference = np.array([one.reference.positions for one in received])
    output = np.array([one.output.positions for one in received])
    moving = np.ptp(reference, axis=1) > 0
    assert moving.any()
    np.testing.assert_allclose(output[:-1], reference[1:], atol=2e-3)
    middle = np.argmin(abs(reference[:, 0] - (HOME[0] + NEAR[0]) / 2))
    speeds = received[middle].reference.velocities
    np.testing.assert_allclose(speeds, 1.5 * SHIFT, atol=0.02)  # of a cubic
    assert not any(received[middle].error.velocities)  # positions are commanded


@in_mujoco
def test_positions_alone_are_joined_by_straight_lines(
    client: Client, at_home: None, states: Topic
) -> None:
    since = states.count
    goal = follow(client, trajectory([(1.0, NEAR)], at_rest=False))
    assert goal.outcome()[0] == "succeeded"
    speeds = np.array([one.reference.velocities[0] for one in states.since(since)])
    moving = speeds[abs(speeds) > 0.01]
    assert len(moving) > 50
    np.testing.assert_allclose(moving, SHIFT[0], atol=0.02)


REJECTED: Mapping[str, tuple[Mapping[str, object], tuple[str, ...]]] = {
    "a joint too few": (
        trajectory([(1.0, HOME[:5])], ARM_JOINTS[:5]),
        ("joints",),
    ),
    "no joints": (trajectory([(1.0, ())], ()), ("joint",)),
    "no points": (trajectory([]), ("mpty",)),
    "an unknown joint": (
        trajectory([(1.0, HOME)], (*ARM_JOINTS[:5], "wrist_4_joint")),
        ("wrist_4_joint",),
    ),
    "times that do not increase": (
        trajectory([(0.5, NEAR), (0.5, HOME)]),
        ("increasing",),
    ),
    "a position too few": (trajectory([(1.0, HOME[:5])]), ("positions",)),
    "not a number": (trajectory([(1.0, (*HOME[:5], math.nan))]), ("nan",)),
    "infinity": (trajectory([(1.0, (math.inf, *HOME[1:]))]), ("inf",)),
}


def other_points(**fields: object) -> Mapping[str, object]:
    """Return a trajectory to HOME, with other fields in its point."""
    found = trajectory([(1.0, HOME)])
    found["points"] = [{"positions": HOME, "time_from_start": 1.0, **fields}]
    return found


REJECTED |= {
    "a velocity too few": (other_points(velocities=[0.0] * 5), ("velocities",)),
    "an acceleration too many": (
        other_points(accelerations=[0.0] * 7),
        ("accelerations",),
    ),
    "an end in motion": (
        other_points(velocities=[0.1] + [0.0] * 5),
        (PAN, "not zero"),
    ),
    "efforts": (other_points(effort=[0.0] * 6), ("effort",)),
}


@in_mujoco
def test_invalid_goals_are_rejected_and_the_active_one_continues(
    client: Client, at_home: None, log: Topic
) -> None:
    active = follow(client, trajectory([(2.0, NEAR)]))
    for what, (message, words) in REJECTED.items():
        since = log.count
        assert not follow(client, message).is_accepted, what
        logged(log, since, *words)
    assert active.outcome()[0] == "succeeded"


@in_mujoco
def test_invalid_messages_on_the_topic_are_ignored_with_a_reason(
    client: Client, at_home: None, states: Topic, log: Topic
) -> None:
    for message, words in REJECTED.values():
        since = log.count
        client.publish(f"/{JTC}/joint_trajectory", TRAJECTORY, message)
        logged(log, since, *words)
    assert distance(states, HOME) < 0.01


@in_mujoco
def test_a_stamped_trajectory_may_have_begun_but_not_ended(
    client: Client, at_home: None, states: Topic, log: Topic
) -> None:
    now = states.last.header.stamp
    since = log.count
    past = trajectory([(0.2, NEAR)], stamp=now - 0.5)
    assert not follow(client, past).is_accepted
    logged(log, since, "past")
    begun = trajectory([(0.2, NEAR), (2.0, HOME)], stamp=states.last.header.stamp - 0.5)
    goal = follow(client, begun)
    assert goal.is_accepted
    assert goal.outcome()[0] == "succeeded"
    arrive(states, HOME)


def test_a_new_goal_aborts_the_old_one_and_takes_its_place(
    client: Client, at_home: None, states: Topic
) -> None:
    first = follow(client, trajectory([(3.0, AWAY)]))
    wait_until_moving(states, 0.1)
    second = follow(client, trajectory([(0.8, HOME)]))
    assert second.is_accepted
    status, result = first.outcome()
    assert (status, result.error_code) == ("aborted", INVALID_GOAL)
    assert result.error_string == "Current goal preempted by new incoming action."
    assert second.outcome()[0] == "succeeded"
    arrive(states, HOME)


@in_mujoco
def test_a_message_on_the_topic_replaces_the_motion_but_not_the_goal(
    client: Client, at_home: None, states: Topic
) -> None:
    goal = follow(client, trajectory([(3.0, AWAY)]))
    wait_until_moving(states, 0.1)
    joints = tuple(reversed(ARM_JOINTS))
    points = [(0.8, tuple(reversed(NEAR)))]
    client.publish(f"/{JTC}/joint_trajectory", TRAJECTORY, trajectory(points, joints))
    status, result = goal.outcome()
    assert (status, result.error_string) == ("succeeded", REACHED)
    arrive(states, NEAR)


def test_a_cancel_holds_the_measured_position(
    client: Client, at_home: None, states: Topic
) -> None:
    goal = follow(client, trajectory([(2.0, AWAY)]))
    moving = wait_until_moving(states)
    response = goal.cancel()
    assert len(response.goals_canceling) == 1
    status, result = goal.outcome()
    assert (status, result.error_code) == ("canceled", 0)
    assert result.error_string == ""
    rest = come_to_rest(states)
    held = states.next(25)[-1]
    for place in (HOME, AWAY):
        assert np.abs(np.subtract(rest.feedback.positions, place)).max() > 0.02
    travelled = np.subtract(rest.feedback.positions, moving.feedback.positions)
    assert np.abs(travelled).max() < 0.15  # some 0.1 s at 0.5 rad/s, the way there
    np.testing.assert_allclose(
        held.feedback.positions, rest.feedback.positions, atol=5e-3
    )


@pytest.mark.usefixtures("at_home")
@pytest.mark.parametrize(
    ("place", "duration", "tolerances"),
    [
        (FAR, 0.1, {}),
        (NEAR, 0.8, {"path_tolerance": [tolerance(ELBOW, 1e-7)]}),
    ],
    ids=["of the parameters", "of the goal"],
)
def test_a_violated_path_tolerance_aborts_and_holds(
    client: Client,
    states: Topic,
    place: Sequence[float],
    duration: float,
    tolerances: Mapping[str, object],
) -> None:
    goal = follow(client, trajectory([(duration, place)]), **tolerances)
    status, result = goal.outcome()
    assert (status, result.error_code) == ("aborted", PATH_VIOLATED)
    upstream, joint = result.error_string.split("; ", 1)
    assert upstream == "Aborted due to path tolerance violation"
    assert "is off by" in joint
    come_to_rest(states)
    assert distance(states, place) > 0.1


def test_a_missed_goal_tolerance_aborts_after_the_goal_s_time(
    client: Client, at_home: None, states: Topic
) -> None:
    goal = follow(
        client,
        trajectory([(0.5, NEAR)]),
        goal_tolerance=[tolerance(ELBOW, 1e-13)],
        goal_time_tolerance=0.2,
    )
    status, result = goal.outcome()
    assert (status, result.error_code) == ("aborted", GOAL_VIOLATED)
    upstream, joint = result.error_string.split("; ", 1)
    assert "is off by" in joint
    text, seconds = upstream.split(" by ")
    assert text == "Aborted due to goal_time_tolerance exceeding"
    assert float(seconds.removesuffix(" seconds")) == pytest.approx(0.2, abs=0.02)
    come_to_rest(states)


@in_mujoco
def test_without_a_goal_time_the_controller_waits_for_ever(
    client: Client, at_home: None, states: Topic
) -> None:
    goal = follow(
        client, trajectory([(0.3, NEAR)]), goal_tolerance=[tolerance(ELBOW, 1e-13)]
    )
    arrive(states, NEAR)
    start = states.last.header.stamp
    states.wait_for_new(lambda state: state.header.stamp > start + 1.0)
    assert not goal.has_ended
    goal.cancel()
    assert goal.outcome()[0] == "canceled"


@in_mujoco
def test_a_tolerance_of_minus_one_is_none(
    client: Client, at_home: None, states: Topic
) -> None:
    goal = follow(
        client, trajectory([(0.1, FAR)]), path_tolerance=[tolerance(PAN, -1.0)]
    )
    assert goal.outcome()[0] == "succeeded"
    arrive(states, FAR)


@in_mujoco
@pytest.mark.parametrize(
    "wrong", [tolerance(LIFT, -2.0), tolerance("wrist_4_joint", 1.0)], ids=["-2", "4"]
)
def test_with_a_wrong_tolerance_all_defaults_stand(
    client: Client, at_home: None, bringup: Bringup, wrong: Mapping[str, object]
) -> None:
    strict = tolerance(ELBOW, 1e-9)
    goal = follow(client, trajectory([(0.5, NEAR)]), path_tolerance=[strict, wrong])
    assert goal.is_accepted
    bringup.wait_for("Using default tolerances")
    assert goal.outcome()[0] == "succeeded"


@in_mujoco
def test_a_partial_goal_needs_a_parameter_and_the_others_hold(
    client: Client, at_home: None, states: Topic
) -> None:
    alone = trajectory([(0.5, [HOME[2] + 0.3])], [ELBOW])
    assert not follow(client, alone).is_accepted
    (answer,) = client.set_parameters(f"/{JTC}", allow_partial_joints_goal=True)
    assert answer.successful, answer.reason
    try:
        assert client.parameters(f"/{JTC}", "allow_partial_joints_goal") == [True]
        goal = follow(client, alone)
        assert goal.is_accepted
        assert goal.outcome()[0] == "succeeded"
        arrive(states, (*HOME[:2], HOME[2] + 0.3, *HOME[3:]))
    finally:
        client.set_parameters(f"/{JTC}", allow_partial_joints_goal=False)


@in_mujoco
def test_a_stamp_in_the_future_is_waited_for(
    client: Client, at_home: None, states: Topic
) -> None:
    start = states.last.header.stamp + 0.8
    since = states.count
    goal = follow(client, trajectory([(0.6, NEAR)], stamp=start, at_rest=False))
    assert goal.outcome()[0] == "succeeded"
    arrive(states, NEAR)
    ended = [
        state.header.stamp
        for state in states.since(since)
        if np.allclose(state.reference.positions, NEAR, atol=1e-6)
    ]
    assert ended[0] == pytest.approx(start + 0.6, abs=0.03)


@in_mujoco
def test_query_state_samples_the_trajectory(
    client: Client, at_home: None, states: Topic
) -> None:
    def query(at: float) -> Message:
        return client.call(
            f"/{JTC}/query_state", "control_msgs/srv/QueryTrajectoryState", time=at
        )

    since = states.count
    goal = follow(client, trajectory([(3.0, NEAR)]))
    began = states.wait_for(
        lambda state: max(map(abs, state.reference.velocities)) > 0.0, since=since
    ).header.stamp
    answer = query(began + 1.5)
    assert answer.success
    assert tuple(answer.name) == ARM_JOINTS
    np.testing.assert_allclose(answer.position, HOME + SHIFT / 2, atol=2e-3)
    np.testing.assert_allclose(answer.velocity, SHIFT / 2, atol=2e-3)
    assert len(answer.acceleration) == 6
    goal.cancel()


@in_mujoco
def test_the_speed_slider_slows_the_trajectory_s_time(
    client: Client, at_home: None, states: Topic
) -> None:
    def slide(fraction: float) -> None:
        answer = client.call(
            "/io_and_status_controller/set_speed_slider",
            "ur_msgs/srv/SetSpeedSliderFraction",
            speed_slider_fraction=fraction,
        )
        assert answer.success
        states.wait_for_new(lambda state: state.speed_scaling_factor == fraction)

    slide(0.5)
    try:
        since = states.count
        assert follow(client, trajectory([(1.0, NEAR)])).outcome()[0] == "succeeded"
        moving = [
            state.header.stamp
            for state in states.since(since)
            if max(map(abs, state.reference.velocities)) > 1e-6
        ]
        assert moving[-1] - moving[0] == pytest.approx(2.0, abs=0.1)
    finally:
        slide(1.0)


def test_a_deactivation_aborts_the_goal_and_rejects_others(
    client: Client, at_home: None, manager: Manager, states: Topic, log: Topic
) -> None:
    goal = follow(client, trajectory([(5.0, AWAY)]))
    wait_until_moving(states, 0.1)
    since = log.count
    assert manager.switch(deactivate=[JTC])
    try:
        status, result = goal.outcome()
        assert (status, result.error_code) == ("aborted", INVALID_GOAL)
        assert (
            result.error_string
            == "Current goal cancelled during deactivate transition."
        )
        assert manager.states()[JTC] == "inactive"
        assert not follow(client, trajectory([(1.0, HOME)])).is_accepted
        logged(log, since, "inactive")
    finally:
        assert manager.switch(activate=[JTC])
    go(client, states, HOME)


def test_its_parameters_are_those_of_the_file(client: Client, bringup: Bringup) -> None:
    names = (
        "joints",
        "command_interfaces",
        "state_interfaces",
        "constraints.goal_time",
        "constraints.stopped_velocity_tolerance",
        f"constraints.{ELBOW}.trajectory",
        f"constraints.{ELBOW}.goal",
        "action_monitor_rate",
        "allow_partial_joints_goal",
    )
    assert client.parameters(f"/{JTC}", *names) == [
        list(ARM_JOINTS),
        ["position"],
        ["position", "velocity"],
        *(0.0, 0.2, 0.2, 0.1, 20.0, False),
    ]


@in_mujoco
def test_a_tolerance_set_as_a_parameter_counts(client: Client, at_home: None) -> None:
    name = f"constraints.{ELBOW}.trajectory"
    (answer,) = client.set_named(f"/{JTC}", {name: 1e-7})
    assert answer.successful, answer.reason
    try:
        status, result = follow(client, trajectory([(0.5, NEAR)])).outcome()
        assert (status, result.error_code) == ("aborted", PATH_VIOLATED)
    finally:
        client.set_named(f"/{JTC}", {name: 0.2})
    (answer,) = client.set_named(f"/{JTC}", {"joints": [PAN]})
    assert not answer.successful
    assert answer.reason


@in_mujoco
def test_ten_thousand_points_are_a_goal(
    client: Client, at_home: None, states: Topic
) -> None:
    points = [(0.5 + 0.001 * k, NEAR) for k in range(10_000)]
    goal = follow(client, trajectory(points))
    assert goal.is_accepted
    arrive(states, NEAR)
    until(lambda: goal.feedback()[-1].index > 100, "some hundred points passed")
    goal.cancel()
    assert goal.outcome()[0] == "canceled"
