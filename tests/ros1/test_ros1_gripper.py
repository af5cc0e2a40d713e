"""The gripper as an action, by actionlib: reached, stalled on a thing, cancelled."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import pytest
from ros import Bringup
from ros_client import Message, Topic, connected, listening, outcome, state
from ur5_rig import GRIPPER
from waits import until

ENGINES = ("mujoco", "gazebo")
OPTIONS = (
    *("--scene", "table_and_cubes", "--gripper-action"),
    *("--initial-pose", "shoulder_lift_joint=-1.2"),
    *("elbow_joint=1.9", "wrist_1_joint=-2.2708"),
)
"""With the red cube of 4 cm between the fingers."""
CLOSED = 0.8133  # [rad]
ABORTED, PREEMPTED, REJECTED, SUCCEEDED = 4, 2, 5, 3
"""Of actionlib_msgs/GoalStatus."""


@pytest.fixture(scope="module")
def client(rospy: ModuleType, bringup: Bringup) -> Message:
    from actionlib import SimpleActionClient
    from control_msgs.msg import GripperCommandAction

    return connected(SimpleActionClient(f"{GRIPPER}/gripper_cmd", GripperCommandAction))


@pytest.fixture(scope="module")
def states(rospy: ModuleType, bringup: Bringup) -> Iterator[Topic]:
    from sensor_msgs.msg import JointState

    with listening("/joint_states", JointState) as states:
        yield states


def goal(position: float, max_effort: float = 0.0) -> Message:
    from control_msgs.msg import GripperCommand, GripperCommandGoal

    return GripperCommandGoal(GripperCommand(position, max_effort))


def wait_for_finger(states: Topic, position: float, within: float = 0.005) -> None:
    """Wait until the finger is there: on a busy machine messages come late."""
    until(
        lambda: abs(state(states)["finger_joint"] - position) < within,
        f"the finger at {position} rad",
    )


def test_it_reaches_an_angle(client: Message, states: Topic) -> None:
    feedback: list[Message] = []
    for position in (0.2, 0.05):
        client.send_goal(goal(position), feedback_cb=feedback.append)
        status, result = outcome(client)
        assert status == SUCCEEDED
        assert (result.reached_goal, result.stalled) == (True, False)
        assert result.position == pytest.approx(position, abs=0.002)
        wait_for_finger(states, position)
    assert feedback
    assert 0.0 < max(one.position for one in feedback) < 0.21


def test_it_stalls_on_a_cube_and_keeps_its_force(
    client: Message, states: Topic
) -> None:
    client.send_goal(goal(CLOSED, 5.0))
    status, result = outcome(client)
    assert status == ABORTED
    assert (result.reached_goal, result.stalled) == (False, True)
    assert 0.3 < result.position < 0.5  # 4 cm of 8.5 cm
    assert result.effort == pytest.approx(5.0)
    squeezed = states.next()[0]
    effort = squeezed.effort[squeezed.name.index("finger_joint")]
    assert effort == pytest.approx(5.0, abs=0.1)  # the drive carries the fingers, too
    client.send_goal(goal(0.05))
    assert outcome(client)[0] == SUCCEEDED


def test_a_cancelled_goal_stops_the_fingers(client: Message, states: Topic) -> None:
    client.send_goal(goal(0.3))
    states.wait_for(
        lambda message: message.position[message.name.index("finger_joint")] > 0.1,
        since=len(states.messages),
    )
    client.cancel_goal()
    status, result = outcome(client)
    assert status == PREEMPTED
    assert not result.reached_goal
    wait_for_finger(states, result.position, within=0.01)
    client.send_goal(goal(0.05))
    assert outcome(client)[0] == SUCCEEDED


def test_invalid_goals_are_rejected(client: Message, bringup: Bringup) -> None:
    for bad, value in (
        (goal(float("nan")), "nan"),
        (goal(0.2, float("inf")), "inf"),
        (goal(2.0), "finger_joint"),
    ):
        client.send_goal(bad)
        assert outcome(client)[0] == REJECTED
        assert value in client.get_goal_status_text()
        assert value in bringup.wait_for("gripper_cmd")
