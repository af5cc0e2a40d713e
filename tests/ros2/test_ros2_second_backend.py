"""The node presents a robot that is no simulation, and leaves out what it lacks."""

from __future__ import annotations

import pytest
from path_robot import REASON, PathRobot
from ros2_client import Client
from ros2_domain import Domain
from ros2_rig import follow, trajectory
from ur5_rig import ARM_JOINTS

import tool0
from tool0.protocol.channel import LocalChannel
from tool0.ros2.node import Ros2Node

PLACE = (0.1, -0.2, 0.3, -0.4, 0.5, 0.6)
LEFT_OUT = {
    "cameras": "list_cameras",
    "the control boxes of arms": "list_arms",
    "hardware components": "list_hardware",
    "the parameters of controllers": "read_controller_parameters",
}


def test_a_robot_that_only_follows_paths_is_driven(
    domain: Domain,
    client: Client,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    for name, value in domain.variables.items():
        monkeypatch.setenv(name, value)
    channel = LocalChannel(PathRobot().backend)
    with tool0.Robot(channel) as robot, Ros2Node(robot) as node:
        node.wait()
        goal = follow(client, trajectory([(0.2, PLACE)]), "paths")
        assert goal.outcome()[0] == "succeeded"
        positions = robot.snapshot.positions
        assert tuple(positions[joint] for joint in ARM_JOINTS) == PLACE
    said = [message.split("left out: ")[-1] for message in caplog.messages]
    assert sorted(said) == sorted(
        f"{use}, since '{method}' is not offered: {REASON}"
        for use, method in LEFT_OUT.items()
    )
