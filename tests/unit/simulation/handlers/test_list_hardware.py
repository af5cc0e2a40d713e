"""The hardware components of a running robot, as ``ros2 control`` lists them."""

from __future__ import annotations

import tool0
from tool0.description.config import DescriptionConfig
from tool0.protocol.hardware import HardwareComponentState, ListHardware

CONTROLLERS = """
moving:
  type: position_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint, elbow_joint]
"""


def listed(robot: tool0.Robot) -> dict[str, HardwareComponentState]:
    return {item.name: item for item in robot.channel.call(ListHardware())}


def claimed(component: HardwareComponentState) -> set[str]:
    return {each.name for each in component.command_interfaces if each.is_claimed}


def test_components_and_claims_of_a_robot_for_ros2(tmp_path) -> None:
    file = tmp_path / "controllers.yaml"
    file.write_text(CONTROLLERS)
    with tool0.bringup(
        description=DescriptionConfig(ros2_control=True),
        control=tool0.ControlConfig(
            controllers_file=file, controllers=["moving"], stopped_controllers=[]
        ),
        realtime=False,
    ) as robot:
        found = listed(robot)
        assert list(found) == ["ur5", "2f85"]
        arm, gripper = found["ur5"], found["2f85"]
        assert (arm.type, arm.state) == ("system", "active")
        assert arm.plugin == "gz_ros2_control/GazeboSimSystem"
        assert claimed(arm) == {"shoulder_pan_joint/position", "elbow_joint/position"}
        assert not claimed(gripper)
        states = {each.name: each.is_available for each in arm.state_interfaces}
        assert states["elbow_joint/effort"]
        assert states["tcp_fts_sensor/force.x"]
        robot.switch(stop=["moving"])
        assert not claimed(listed(robot)["ur5"])


def test_transmissions_are_one_component() -> None:
    with tool0.bringup(realtime=False) as robot:
        (component,) = robot.channel.call(ListHardware())
        assert component.name == robot.description.model.name
        assert "elbow_joint/effort" in claimed(component)
        assert len(component.state_interfaces) == 3 * 7
