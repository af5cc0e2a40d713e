"""Cells of two robots: one manager with prefixed names, or one in each namespace."""

from __future__ import annotations

import numpy as np
import pytest
from ros2_domain import Domain
from ros2_manager import Manager
from ros2_rig import JTC, STATE, follow, trajectory
from ur5_rig import ARM_JOINTS, HOME
from waits import until

ROBOTS = ("--robots", "left=ur5e+2f85@0,0.5,0", "right=ur10e+hande@0,-0.5,0")
SIDES = ("left", "right")
JOINT_STATE = "sensor_msgs/msg/JointState"
SHIFT = {"left": 0.2, "right": -0.1}


@pytest.mark.parametrize(
    "has_namespaces", [False, True], ids=["prefixes", "namespaces"]
)
def test_both_arms_follow_at_once(own_domain: Domain, has_namespaces: bool) -> None:
    client = own_domain.client()
    own_domain.bring_up(*ROBOTS, *(["--namespaces"] if has_namespaces else []))
    between = "/" if has_namespaces else "_"
    joint_prefix = "" if has_namespaces else "{}_"
    names = {side: f"{side}{between}{JTC}" for side in SIDES}
    managers = {side: f"/{side}/controller_manager" for side in SIDES}
    if not has_namespaces:
        managers = dict.fromkeys(SIDES, "/controller_manager")
    for side, manager in managers.items():
        until(lambda name=manager: name in client.nodes(), f"the manager of {side}")
        states = Manager(client, manager).states()
        assert states[JTC if has_namespaces else names[side]] == "active"
    goals, ends = [], {}
    for side in SIDES:
        joints = [joint_prefix.format(side) + joint for joint in ARM_JOINTS]
        ends[side] = np.add(HOME, SHIFT[side])
        points = [(1.5, tuple(map(float, ends[side])))]
        goals.append(follow(client, trajectory(points, joints), names[side]))
    assert [goal.outcome()[0] for goal in goals] == ["succeeded", "succeeded"]
    for side in SIDES:
        with client.listening(f"/{names[side]}/controller_state", STATE) as states:
            (state,) = states.next()
        assert state.feedback.positions == pytest.approx(ends[side], abs=2e-3)
    topic = "/left/joint_states" if has_namespaces else "/joint_states"
    with client.listening(topic, JOINT_STATE) as joint_states:
        published = set(joint_states.next()[0].name)
    joints = {
        joint_prefix.format(side) + joint for side in SIDES for joint in ARM_JOINTS
    }
    assert joints <= published
    assert len([name for name in published if name.endswith("elbow_joint")]) == (
        1 if has_namespaces else 2
    )
