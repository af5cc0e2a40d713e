"""The calls of rqt_joint_trajectory_controller and of MoveIt's controller manager."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np
import pytest
from ros import Bringup
from ros2_client import Client, Topic
from ros2_manager import Manager
from ros2_rig import (
    GRIPPER,
    JTC,
    REACHED,
    STATE,
    TRAJECTORY,
    arrive,
    come_to_rest,
    follow,
    go,
    wait_until_moving,
)
from ur5_rig import ARM_JOINTS, HOME
from waits import until

RQT_SERVICES = (
    *("list_controllers", "list_controller_types", "load_controller"),
    *("unload_controller", "switch_controller", "reload_controller_libraries"),
)
RATE = 10.0  # [Hz] of rqt's commands
LEAD = 1.0  # [s] of each of them, with the speed slider as it starts
DRAGGED = np.array([0.5, 0.2, -0.3, 0.2, 0.2, -0.5])  # [rad] from HOME
PLANNED = np.array([0.4, 0.3, -0.3, 0.2, 0.1, -0.4])  # [rad] from HOME
PERIOD = 0.1  # [s] between the points that MoveIt's time parameterization makes


@pytest.fixture(scope="module")
def states(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening(f"/{JTC}/controller_state", STATE) as states:
        yield states


def test_rqt_finds_manager_controller_and_limits(
    client: Client, bringup: Bringup
) -> None:
    names = {f"/controller_manager/{name}" for name in RQT_SERVICES}
    until(lambda: names <= client.services().keys(), "the manager's services")
    shown = [
        one
        for one in Manager(client).controllers().values()
        if "JointTrajectoryController" in one.type and one.state == "active"
    ]
    assert [one.name for one in shown] == [JTC]
    joints = [
        interface.removesuffix("/position")
        for interface in shown[0].required_state_interfaces
        if interface.endswith("/position")
    ]
    assert sorted(joints) == sorted(ARM_JOINTS)
    with client.listening(
        "/robot_description", "std_msgs/msg/String", latched=True
    ) as topic:
        robot = ElementTree.fromstring(topic.last.data)
    for joint in robot.findall("joint"):
        if joint.get("name") in joints:
            limit = joint.find("limit")
            assert limit is not None
            assert float(limit.get("velocity", "0")) > 0.0


def test_rqt_drags_the_arm_smoothly(
    client: Client, bringup: Bringup, states: Topic
) -> None:
    """Ten messages a second, without a stamp, each with one point LEAD away."""
    go(client, states, HOME)
    since = states.count
    start = time.monotonic()
    for k in range(1, 36):
        share = min(k / 20, 1.0)
        point = {"positions": list(HOME + share * DRAGGED), "time_from_start": LEAD}
        message = {"joint_names": ARM_JOINTS, "points": [point]}
        client.publish(f"/{JTC}/joint_trajectory", TRAJECTORY, message)
        time.sleep(max(start + k / RATE - time.monotonic(), 0.0))
    arrive(states, HOME + DRAGGED)
    received = states.since(since)
    positions = np.array([one.feedback.positions for one in received])
    speeds = np.array([one.feedback.velocities for one in received])
    assert np.abs(speeds).max() < 0.8  # [rad/s]
    overshoot = (positions - HOME) / DRAGGED
    assert overshoot.max() < 1.05
    assert overshoot.min() > -0.05


def planned(duration: float) -> dict[str, object]:
    """Return a trajectory as MoveIt plans it: with velocities and accelerations."""
    points = []
    for k in range(round(duration / PERIOD) + 1):
        phase = math.pi * k * PERIOD / duration
        last = k * PERIOD == duration
        points.append(
            {
                "positions": list(HOME + PLANNED * (1 - math.cos(phase)) / 2),
                "velocities": list(
                    0.0 * PLANNED
                    if last or k == 0
                    else PLANNED * math.pi / duration * math.sin(phase) / 2
                ),
                "accelerations": list(
                    PLANNED * (math.pi / duration) ** 2 * math.cos(phase) / 2
                ),
                "time_from_start": k * PERIOD,
            }
        )
    return {
        "header": {"frame_id": "world"},
        "joint_names": ARM_JOINTS,
        "points": points,
    }


def test_moveit_executes_a_plan_and_grips(
    client: Client, bringup: Bringup, states: Topic
) -> None:
    go(client, states, HOME)
    status, result = follow(client, planned(2.0)).outcome()
    assert (status, result.error_string) == ("succeeded", REACHED)
    arrive(states, HOME + PLANNED)
    command = {"name": ["finger_joint"], "position": [0.3]}
    goal = client.send(
        f"/{GRIPPER}/gripper_cmd",
        "control_msgs/action/ParallelGripperCommand",
        {"command": command},
    )
    assert goal.outcome()[0] == "succeeded"


def test_moveit_stops_a_plan_by_cancelling_it(
    client: Client, bringup: Bringup, states: Topic
) -> None:
    go(client, states, HOME)
    goal = follow(client, planned(4.0))
    wait_until_moving(states, 0.1)
    goal.cancel()
    assert goal.outcome()[0] == "canceled"
    rest = come_to_rest(states)
    assert abs(rest.feedback.positions[0] - HOME[0] - PLANNED[0]) > 0.1
