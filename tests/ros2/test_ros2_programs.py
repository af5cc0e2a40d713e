"""Programs of ROS 2 themselves, where they are installed beside rclpy."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from ros import Bringup
from ros2_client import Client
from ros2_domain import Domain
from ros2_manager import Manager
from ros2_rig import JTC

FILE = Path(__file__).parent.parent / "data" / "controllers" / "ros2_variants.yaml"
SPAWNED = "position_forwarder"
STATES = ("/joint_states", "sensor_msgs/msg/JointState")
WITHOUT_DAEMON = ("--no-daemon", "--spin-time", "3")
"""Discover the graph for that long [wall s]."""
GOAL = (
    "{trajectory: {joint_names: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, "
    "wrist_1_joint, wrist_2_joint, wrist_3_joint], points: [{positions: "
    "[0.3, -1.5, 0.3, -1.5, 0.3, 0.3], time_from_start: {sec: 1}}]}}"
)


class Programs:
    """Runs programs by the module that has their ``main``."""

    def __init__(self, domain: Domain) -> None:
        self._domain = domain

    def run(self, module: str, *arguments: str) -> str:
        """Run it to its end; it has to succeed.  Return its output."""
        program = f"import sys; from {module} import main; sys.exit(main())"
        return self._domain.run("-c", program, *arguments)

    def ros2(self, *arguments: str) -> str:
        return self.run("ros2cli.cli", *arguments)

    def require(self, *modules: str) -> None:
        """Skip without them: no set-up of ours installs them."""
        try:
            self._domain.run("-c", f"import {', '.join(modules)}")
        except AssertionError:
            pytest.skip(f"no {' or '.join(modules)} beside rclpy")


@pytest.fixture(scope="module")
def programs(domain: Domain) -> Iterator[Programs]:
    programs = Programs(domain)
    programs.require("ros2cli")
    yield programs
    programs.ros2("daemon", "stop")  # which some of the commands start


@pytest.fixture
def ros2_control(programs: Programs, bringup: Bringup) -> Programs:
    programs.require("ros2cli", "ros2controlcli", "controller_manager")
    return programs


@pytest.fixture
def spawned(ros2_control: Programs) -> Iterator[Programs]:
    """Load a controller by the spawner, and unload it by the unspawner."""
    ros2_control.run(
        "controller_manager.spawner", SPAWNED, "--inactive", "-p", str(FILE)
    )
    yield ros2_control
    ros2_control.run("controller_manager.unspawner", SPAWNED)


def test_spawner_and_ros2_control(spawned: Programs) -> None:
    def state(controller: str) -> str:
        listed = spawned.ros2("control", "list_controllers")
        rows = map(str.split, listed.splitlines())
        (row,) = (row for row in rows if row[:1] == [controller])
        return row[2]

    assert state(SPAWNED) == "inactive"
    assert state(JTC) == "active"
    interfaces = spawned.ros2("control", "list_hardware_interfaces")
    assert "elbow_joint/position [available] [claimed]" in interfaces
    assert "elbow_joint/velocity [available] [unclaimed]" in interfaces
    assert "active" in spawned.ros2("control", "list_hardware_components")
    kinds = spawned.ros2("control", "list_controller_types")
    assert "joint_trajectory_controller/JointTrajectoryController" in kinds
    switch = ("control", "switch_controllers", "--strict")
    spawned.ros2(*switch, "--activate", SPAWNED, "--deactivate", JTC)
    assert state(SPAWNED) == "active"
    spawned.ros2(*switch, "--activate", JTC, "--deactivate", SPAWNED)
    assert state(JTC) == "active"


def test_ros2_topic_action_param_node_and_service(
    programs: Programs, bringup: Bringup
) -> None:
    programs.require("ros2cli", "ros2topic", "ros2action", "ros2param", "ros2node")
    topics = programs.ros2("topic", "list", *WITHOUT_DAEMON)
    assert f"/{JTC}/controller_state" in topics.split()
    echoed = programs.ros2("topic", "echo", "--once", *STATES)
    assert "elbow_joint" in echoed
    action = f"/{JTC}/follow_joint_trajectory"
    kind = "control_msgs/action/FollowJointTrajectory"
    sent = programs.ros2("action", "send_goal", action, kind, GOAL)
    assert "Goal finished with status: SUCCEEDED" in sent
    assert f"/{JTC}" in programs.ros2("node", "list", *WITHOUT_DAEMON).split()
    parameter = (f"/{JTC}", "command_interfaces")
    assert "position" in programs.ros2("param", "get", *parameter, *WITHOUT_DAEMON)
    services = programs.ros2("service", "list", *WITHOUT_DAEMON).split()
    assert f"/{JTC}/query_state" in services


def test_a_spawner_that_is_killed_unloads(
    domain: Domain, client: Client, ros2_control: Programs
) -> None:
    manager = Manager(client)
    name = "second_broadcaster"
    program = (
        "import sys; from controller_manager.spawner import main; sys.exit(main())"
    )
    with subprocess.Popen(
        [
            *(str(domain.ros2.python), "-c", program),
            *(name, "--unload-on-kill", "-p", str(FILE)),
        ],
        env=dict(domain.ros_environment),
        stderr=subprocess.PIPE,
        text=True,
    ) as spawner:
        assert spawner.stderr is not None
        assert any("Waiting until interrupt" in line for line in spawner.stderr)
        assert manager.states()[name] == "active"
        spawner.terminate()
        spawner.communicate()
    assert spawner.returncode == 0
    assert name not in manager.states()
