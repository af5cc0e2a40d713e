"""A trajectory controller by its clients: actionlib, the topics, query_state."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from types import ModuleType

import numpy as np
import pytest
from ros import Bringup
from ros_client import (
    Message,
    Topic,
    arm_client,
    at,
    call,
    follow_goal,
    listening,
    outcome,
    publishing,
    trajectory,
)
from ur5_rig import ARM, ARM_JOINTS, AWAY, HOME
from waits import until

ENGINES = ("mujoco", "gazebo")
NEAR = tuple(q + 0.2 for q in HOME)
SHIFT = np.subtract(NEAR, HOME)


in_mujoco = pytest.mark.parametrize("bringup", ["mujoco"], indirect=True)
"""For what does not depend on the physics."""


@pytest.fixture(scope="module")
def client(rospy: ModuleType, bringup: Bringup) -> Iterator[Message]:
    client = arm_client()
    yield client
    client.stop_tracking_goal()


@pytest.fixture(scope="module")
def states(rospy: ModuleType, bringup: Bringup) -> Iterator[Topic]:
    from control_msgs.msg import JointTrajectoryControllerState

    with listening(f"/{ARM}/state", JointTrajectoryControllerState) as states:
        yield states


@pytest.fixture
def at_home(client: Message, states: Topic) -> None:
    """Have the arm at HOME, at rest."""
    duration = 0.5 + distance(states, HOME)  # at 1.5 rad/s at most
    client.send_goal(follow_goal(trajectory([(duration, HOME)])))
    status, _ = outcome(client)
    assert status == SUCCEEDED
    arrive(states, HOME)


SUCCEEDED, PREEMPTED, ABORTED, REJECTED = 3, 2, 4, 5
"""Of actionlib_msgs/GoalStatus."""


def distance(states: Topic, place: Sequence[float]) -> float:
    (now,) = states.next()
    return float(np.abs(np.subtract(now.actual.positions, place)).max())


def arrive(states: Topic, place: Sequence[float]) -> None:
    """Wait until the arm is there: messages come late, and goals have tolerances."""
    until(lambda: distance(states, place) < 0.02, f"the arm at {place}")


def come_to_rest(states: Topic) -> Message:
    """Wait until desired and actual velocities are zero; return that state."""
    since = len(states.messages)
    return states.wait_for(
        lambda state: (
            max(map(abs, state.desired.velocities)) == 0.0
            and max(map(abs, state.actual.velocities)) < 0.02
        ),
        since=since,
    )


def test_a_goal_succeeds_and_the_arm_is_there(
    client: Message, at_home: None, states: Topic
) -> None:
    feedback: list[Message] = []
    client.send_goal(
        follow_goal(trajectory([(0.6, NEAR), (1.2, HOME), (2.0, NEAR)])),
        feedback_cb=feedback.append,
    )
    status, result = outcome(client)
    assert (status, result.error_code, result.error_string) == (SUCCEEDED, 0, "")
    arrive(states, NEAR)
    # The feedback, at action_monitor_rate of the controller's YAML: 10 Hz.
    stamps = [at(one.header.stamp) for one in feedback]
    assert len(stamps) / 2.0 == pytest.approx(10.0, abs=1.5)
    assert np.median(np.diff(stamps)) == pytest.approx(0.1, abs=0.009)
    for one in feedback:
        assert tuple(one.joint_names) == ARM_JOINTS
        for point in (one.desired, one.actual, one.error):
            assert len(point.positions) == len(point.velocities) == 6
        np.testing.assert_allclose(
            np.subtract(one.desired.positions, one.actual.positions),
            one.error.positions,
            atol=1e-12,
        )
        assert len(one.desired.accelerations) == 6
    assert max(at(one.actual.time_from_start) for one in feedback) > 1.5


@in_mujoco
def test_the_gripper_s_feedback_comes_at_its_20_hz(
    rospy: ModuleType, bringup: Bringup
) -> None:
    client = arm_client("gripper_controller")
    feedback: list[Message] = []
    goal = trajectory([(1.0, [0.4])], ["finger_joint"])
    client.send_goal(follow_goal(goal), feedback_cb=feedback.append)
    assert outcome(client)[0] == SUCCEEDED
    gaps = np.diff([at(one.header.stamp) for one in feedback])
    assert len(feedback) >= 18
    assert np.mean(gaps) == pytest.approx(0.05, rel=0.1)


def test_the_state_topic_has_desired_and_actual_motion(
    client: Message, at_home: None, states: Topic
) -> None:
    since = len(states.messages)
    client.send_goal(follow_goal(trajectory([(1.0, NEAR)])))
    outcome(client)
    received = states.messages[since:]
    stamps = np.array([at(one.header.stamp) for one in received])
    assert len(received) / (stamps[-1] - stamps[0]) == pytest.approx(125.0, rel=0.03)
    desired = np.array([one.desired.positions for one in received])
    speeds = np.array([one.desired.velocities for one in received])
    slope = np.diff(desired, axis=0) / np.diff(stamps)[:, np.newaxis]
    middle = (speeds[1:] + speeds[:-1]) / 2
    assert np.abs(slope - middle).max() < 0.02  # [rad/s]
    assert np.abs(speeds).max() == pytest.approx(1.5 * 0.2, rel=0.02)  # of a cubic


def test_a_second_goal_preempts_the_first(
    client: Message, at_home: None, states: Topic
) -> None:
    ended: list[tuple[int, Message]] = []
    client.send_goal(follow_goal(trajectory([(3.0, AWAY)])))
    until(lambda: client.get_state() == 1, "an active goal")
    first = client.gh
    other = arm_client()
    other.send_goal(
        follow_goal(trajectory([(0.8, HOME)])),
        done_cb=lambda status, result: ended.append((status, result)),
    )
    status, result = outcome(client)
    assert client.gh is first
    assert (status, result.error_code) == (PREEMPTED, 0)
    assert outcome(other)[0] == SUCCEEDED
    assert until(lambda: ended, "the callback")[0][0] == SUCCEEDED
    arrive(states, HOME)


def test_a_cancel_stops_the_arm(client: Message, at_home: None, states: Topic) -> None:
    client.send_goal(follow_goal(trajectory([(2.0, AWAY)])))
    states.wait_for(
        lambda state: max(map(abs, state.actual.velocities)) > 0.2,
        since=len(states.messages),
    )
    client.cancel_goal()
    status, _ = outcome(client)
    assert status == PREEMPTED
    rest = come_to_rest(states)
    stayed = states.next(25)[-1]
    for place in (HOME, AWAY):
        assert np.abs(np.subtract(rest.actual.positions, place)).max() > 0.05
    np.testing.assert_allclose(
        stayed.actual.positions, rest.actual.positions, atol=5e-3
    )


@pytest.mark.usefixtures("at_home")
@pytest.mark.parametrize(
    ("point", "tolerances", "expected"),
    [
        ((0.1, (0.4, *HOME[1:])), {}, (-4, ARM_JOINTS[0])),  # 6 rad/s; it has 3.15
        ((0.8, NEAR), {"path_tolerance": 1e-5}, (-4, "elbow_joint")),
        ((0.8, NEAR), {"goal_tolerance": 1e-9}, (-5, "elbow_joint")),
    ],
)
def test_a_violated_tolerance_aborts(
    client: Message,
    states: Topic,
    point: tuple[float, Sequence[float]],
    tolerances: dict[str, float],
    expected: tuple[int, str],
) -> None:
    """Those of the controller's YAML, or of the goal instead."""
    from control_msgs.msg import JointTolerance
    from rospy import Duration

    code, joint = expected
    own = {
        kind: [JointTolerance(name=joint, position=tolerance)]
        for kind, tolerance in tolerances.items()
    }
    goal = follow_goal(trajectory([point]), goal_time_tolerance=Duration(0.1), **own)
    client.send_goal(goal)
    status, result = outcome(client)
    assert (status, result.error_code) == (ABORTED, code)
    assert joint in result.error_string
    come_to_rest(states)


INVALID = {
    "an unknown joint": (
        -2,
        lambda: trajectory([(1.0, HOME)], (*ARM_JOINTS[:5], "wrist_4_joint")),
    ),
    "a joint too few": (-2, lambda: trajectory([(1.0, HOME[:5])], ARM_JOINTS[:5])),
    "no joints": (-2, lambda: trajectory([(1.0, ())], ())),
    "a number too few": (-1, lambda: trajectory([(1.0, HOME[:5])])),
    "not a number": (-1, lambda: trajectory([(1.0, (*HOME[:5], math.nan))])),
    "infinity": (-1, lambda: trajectory([(1.0, (math.inf, *HOME[1:]))])),
    "times that go back": (-1, lambda: trajectory([(1.0, NEAR), (0.5, HOME)])),
    "beyond the limits": (-1, lambda: trajectory([(1.0, (7.0, *HOME[1:]))])),
}


@in_mujoco
def test_invalid_goals_are_rejected_and_the_active_one_continues(
    client: Message, at_home: None, bringup: Bringup
) -> None:
    other = arm_client()
    other.send_goal(follow_goal(trajectory([(1.5, NEAR)])))
    until(lambda: other.get_state() == 1, "an active goal")
    for what, (code, make) in INVALID.items():
        client.send_goal(follow_goal(make()))
        status, result = outcome(client)
        assert (status, result.error_code) == (REJECTED, code), what
        assert result.error_string == client.get_goal_status_text() != "", what
        bringup.wait_for("follow_joint_trajectory")
    assert outcome(other)[0] == SUCCEEDED


@in_mujoco
def test_points_in_the_past_are_dropped_and_all_of_them_rejected(
    rospy: ModuleType, client: Message, at_home: None
) -> None:
    past = rospy.Time.now() - rospy.Duration(0.5)
    client.send_goal(follow_goal(trajectory([(0.2, NEAR), (1.5, HOME)], stamp=past)))
    assert outcome(client)[0] == SUCCEEDED
    client.send_goal(follow_goal(trajectory([(0.2, NEAR)], stamp=past)))
    status, result = outcome(client)
    assert (status, result.error_code) == (REJECTED, -1)


@in_mujoco
def test_a_stamp_in_the_future_is_waited_for(
    rospy: ModuleType, client: Message, at_home: None, states: Topic
) -> None:
    start = rospy.Time.now() + rospy.Duration(0.6)
    client.send_goal(follow_goal(trajectory([(0.6, NEAR)], stamp=start)))
    since = len(states.messages)
    assert outcome(client)[0] == SUCCEEDED
    begin, end = start.to_sec(), start.to_sec() + 0.6
    seen = [(at(state.header.stamp), state) for state in states.messages[since:]]
    clear = [it for it in seen if min(abs(it[0] - begin), abs(it[0] - end)) > 0.0015]
    moving = [max(map(abs, state.desired.velocities)) > 0.0 for _, state in clear]
    assert moving == [begin < stamp < end for stamp, _ in clear]
    assert clear[0][0] < begin
    assert any(moving)


@in_mujoco
def test_query_state_samples_the_trajectory(
    rospy: ModuleType, client: Message, at_home: None
) -> None:
    from control_msgs.srv import QueryTrajectoryState

    def query(time: Message) -> Message:
        return call(f"/{ARM}/query_state", QueryTrajectoryState, time)

    start = rospy.Time.now() + rospy.Duration(0.2)
    client.send_goal(follow_goal(trajectory([(1.0, NEAR)], stamp=start)))
    until(lambda: client.get_state() == 1, "an active goal")
    answer = query(start + rospy.Duration(0.5))
    assert tuple(answer.name) == ARM_JOINTS
    np.testing.assert_allclose(answer.position, HOME + SHIFT / 2, atol=2e-3)
    np.testing.assert_allclose(answer.velocity, 1.5 * SHIFT, atol=2e-3)
    assert len(answer.acceleration) == 6
    after = query(start + rospy.Duration(60))
    np.testing.assert_allclose(after.position, NEAR)
    np.testing.assert_allclose(after.velocity, np.zeros(6))
    now = query(rospy.Time.now())
    assert np.abs(np.subtract(now.position, HOME)).max() <= 0.2
    for past in (rospy.Time(0, 1), rospy.Time()):
        with pytest.raises(rospy.ServiceException):
            query(past)
    assert outcome(client)[0] == SUCCEEDED


def test_a_trajectory_on_the_topic_moves_the_arm_and_preempts_goals(
    client: Message, at_home: None, states: Topic, bringup: Bringup
) -> None:
    from trajectory_msgs.msg import JointTrajectory

    with publishing(f"/{ARM}/command", JointTrajectory) as command:
        client.send_goal(follow_goal(trajectory([(3.0, AWAY)])))
        until(lambda: client.get_state() == 1, "an active goal")
        joints = tuple(reversed(ARM_JOINTS))
        command(trajectory([(0.6, tuple(reversed(NEAR)))], joints))
        assert outcome(client)[0] == PREEMPTED
        arrive(states, NEAR)
        for _, make in INVALID.values():
            command(make())
            bringup.wait_for(f"/{ARM}/command: ")
        command(trajectory([(5.0, AWAY)]))
        states.wait_for(
            lambda state: max(map(abs, state.actual.velocities)) > 0.05,
            since=len(states.messages),
        )
        command(trajectory([], ()))  # stop
        come_to_rest(states)
        assert distance(states, AWAY) > 0.1


def test_a_stopped_controller_rejects_goals(
    rospy: ModuleType, client: Message, bringup: Bringup
) -> None:
    from control_msgs.srv import QueryTrajectoryState
    from controller_manager_msgs.srv import SwitchController

    def switch(start: list[str], stop: list[str]) -> None:
        name = "/controller_manager/switch_controller"
        assert call(name, SwitchController, start, stop, 2, False, 0.0).ok

    client.send_goal(follow_goal(trajectory([(5.0, AWAY)])))
    until(lambda: client.get_state() == 1, "an active goal")
    switch([], [ARM])
    try:
        assert outcome(client)[0] == PREEMPTED
        late = arm_client()
        late.send_goal(follow_goal(trajectory([(1.0, HOME)])))
        status, result = outcome(late)
        assert (status, result.error_code) == (REJECTED, -1)
        assert ARM in result.error_string
        with pytest.raises(rospy.ServiceException):
            call(f"/{ARM}/query_state", QueryTrajectoryState, rospy.Time.now())
    finally:
        switch([ARM], [])
    client.send_goal(follow_goal(trajectory([(1.0, HOME)])))
    assert outcome(client)[0] == SUCCEEDED


@in_mujoco
def test_goals_after_a_reset_are_not_recalled(
    rospy: ModuleType, client: Message, at_home: None
) -> None:
    """Though the last cancellation is then later than they are."""
    from std_srvs.srv import Empty

    before = rospy.Time.now()
    client.cancel_goals_at_and_before_time(before)
    call("/gazebo/reset_simulation", Empty)
    until(lambda: rospy.Time.now() < before, "a clock that was reset")
    client.send_goal(follow_goal(trajectory([(0.5, NEAR)])))
    assert outcome(client)[0] == SUCCEEDED
