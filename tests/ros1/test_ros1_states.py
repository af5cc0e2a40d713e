"""What a bring-up tells: parameters, time, joint states, transforms."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from types import ModuleType

import numpy as np
import pytest
from promised import require_engine
from ros import Bringup, Ros
from ros_client import listening
from ur5_rig import ARM, ARM_JOINTS, GRIPPER, HOME

from tool0.interfaces.ros1.parameter_server import with_mesh_files

JOINTS = (
    "elbow_joint",
    "finger_joint",
    "shoulder_lift_joint",
    "shoulder_pan_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
"""As ros_control has them: by name."""


@pytest.fixture(scope="module", params=["mujoco", "gazebo"])
def bringup(ros: Ros, request: pytest.FixtureRequest) -> Iterator[Bringup]:
    require_engine(request.param)
    bringup = ros.bring_up("--engine", request.param)
    yield bringup
    bringup.close()


def test_robot_description_is_what_describe_prints(ros: Ros, bringup: Bringup) -> None:
    described = subprocess.run(
        [sys.executable, "-m", "tool0", "describe", "urdf"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    found = with_mesh_files(described)  # RViz shall find them from any terminal
    assert ros.parameter("/robot_description").strip() == found.strip()


def test_the_controllers_yaml_is_at_their_names(ros: Ros, bringup: Bringup) -> None:
    arm = ros.parameter(f"/{ARM}")
    assert arm["type"] == "effort_controllers/JointTrajectoryController"
    assert arm["joints"][0] == "shoulder_pan_joint"
    assert ros.parameter(f"/{ARM}/gains/shoulder_pan_joint/p") == 4000
    assert ros.parameter(f"/{ARM}/constraints/goal_time") == 0.6
    assert ros.parameter(f"/{GRIPPER}/joints") == ["finger_joint"]
    assert ros.parameter("/joint_state_controller/publish_rate") == 125
    assert ros.parameter("/use_sim_time") is True


def test_the_clock_goes_on_and_never_back(rospy: ModuleType, bringup: Bringup) -> None:
    from rosgraph_msgs.msg import Clock

    with listening("/clock", Clock) as clock:
        times = [message.clock.to_nsec() for message in clock.next(250)]
    steps = np.diff(times)
    assert steps.min() > 0
    assert np.median(steps) == 8_000_000


def test_rostopic_measures_125_joint_states_a_second(
    ros: Ros, bringup: Bringup
) -> None:
    window = 250  # an arrival that is a tick late or early makes 0.5 Hz of it
    answer = ros.outcome(
        *("rostopic", "hz", "/joint_states", "-w", str(window)), patience=4.5
    )
    rates = re.findall(r"average rate: ([\d.]+)\n.*window: (\d+)", answer.stdout)
    rate, counted = rates[-1]
    assert int(counted) > 200
    assert float(rate) == pytest.approx(125.0, abs=1.0)


def test_joint_states_are_in_ros_control_s_order_and_sane(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from sensor_msgs.msg import JointState

    with listening("/joint_states", JointState) as states:
        first, last = states.next(50)[::49]
    assert tuple(last.name) == JOINTS
    place = dict(zip(last.name, last.position, strict=True))
    arm = [place[joint] for joint in ARM_JOINTS]
    np.testing.assert_allclose(arm, HOME, atol=0.02)
    assert place["finger_joint"] == pytest.approx(0.0, abs=0.01)
    assert np.abs(last.velocity).max() < 0.01
    effort = dict(zip(last.name, last.effort, strict=True))
    assert 10.0 < abs(effort["shoulder_lift_joint"]) < 60.0  # [N·m]: it carries the arm
    assert last.header.stamp > first.header.stamp
