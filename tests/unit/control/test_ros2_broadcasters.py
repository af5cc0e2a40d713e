"""Controllers that move nothing: what they claim and read."""

from __future__ import annotations

import pytest
from raises_naming import raises_naming

from tool0.control.config import ControllerConfig
from tool0.control.controller import ControllerSpec
from tool0.control.parameters import RobotJoints
from tool0.description.loading import assemble
from tool0.description.model import Interface
from tool0.errors import ConfigError

MODEL = assemble(prefix="left_", ros2_control=True).model
ROBOT = RobotJoints(
    MODEL.joint_by_name,
    {item.joint: item.interfaces for item in MODEL.transmissions},
    hardware=MODEL.hardware,
    grippers=MODEL.grippers,
)
WITHOUT_HARDWARE = RobotJoints(
    MODEL.joint_by_name, {"left_elbow_joint": (Interface.POSITION,)}
)
JSB = "joint_state_broadcaster/JointStateBroadcaster"
FTS = "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster"
FTS_OF_UR = "ur_controllers/ForceTorqueStateBroadcaster"


def parsed(
    kind: str, *lines: str, name: str = "c", robot: RobotJoints = ROBOT
) -> ControllerSpec:
    text = "\n".join([f"{name}:", "  ros__parameters:", f"    type: {kind}"])
    text += "".join(f"\n    {line}" for line in lines)
    return ControllerConfig.from_text(text).spec(name, robot)


def test_joint_states_are_those_of_the_hardware_with_mimic_joints() -> None:
    states = parsed(JSB).state_interfaces
    assert "left_elbow_joint/effort" in states
    assert "left_right_outer_knuckle/position" not in states
    assert "left_right_finger_joint/position" in states or any(
        state.startswith("left_right_") for state in states
    )
    assert parsed(JSB, robot=WITHOUT_HARDWARE).state_interfaces == tuple(
        f"left_elbow_joint/{kind}" for kind in ("position", "velocity", "effort")
    )


def test_joints_and_interfaces_together_select_joint_states() -> None:
    joints = "joints: [left_elbow_joint, left_finger_joint]"
    assert parsed(JSB, joints).state_interfaces == parsed(JSB).state_interfaces
    chosen = parsed(JSB, joints, "interfaces: [position]").state_interfaces
    assert chosen == ("left_elbow_joint/position", "left_finger_joint/position")
    with raises_naming(ConfigError, ":4", "'left_finger_joint/effort'"):
        parsed(JSB, joints, "interfaces: [effort]")


def test_a_wrench_is_that_of_a_sensor_of_the_hardware() -> None:
    sensor = "sensor_name: left_tcp_fts_sensor"
    spec = parsed(FTS, sensor, "frame_id: tool0")
    assert len(spec.state_interfaces) == 6
    assert spec.state_interfaces[0] == "left_tcp_fts_sensor/force.x"
    assert parsed(
        FTS_OF_UR,
        *(sensor, "frame_id: tool0", "topic_name: ft_data"),
        "state_interface_names: [force.x, torque.z]",
    ).state_interfaces == (
        *("left_tcp_fts_sensor/force.x", "left_tcp_fts_sensor/torque.z"),
    )
    with raises_naming(ConfigError, ":4", "did you mean 'left_tcp_fts_sensor'"):
        parsed(FTS, "sensor_name: tcp_fts_sensor", "frame_id: tool0")
    with raises_naming(ConfigError, "either 'sensor_name' or"):
        parsed(FTS, "frame_id: tool0")
    with raises_naming(ConfigError, "'frame_id'"):
        parsed(FTS, sensor)


@pytest.mark.parametrize(
    ("kind", "lines", "states"),
    [
        (
            "pose_broadcaster/PoseBroadcaster",
            ["pose_name: left_tcp_pose", "frame_id: left_base"],
            {"left_tcp_pose/position.x", "left_tcp_pose/orientation.w"},
        ),
        (
            "ur_controllers/SpeedScalingStateBroadcaster",
            ["tf_prefix: left_"],
            {"left_speed_scaling/speed_scaling_factor"},
        ),
        (
            "ur_controllers/GPIOController",
            ["tf_prefix: left_"],
            {"left_gpio/digital_output_17", "left_payload/mass"},
        ),
    ],
)
def test_state_interfaces_have_the_names_of_the_driver(
    kind: str, lines: list[str], states: set[str]
) -> None:
    assert states <= set(parsed(kind, *lines).state_interfaces)


def test_the_control_box_and_the_gripper_claim_what_they_write() -> None:
    box = parsed("ur_controllers/GPIOController", "tf_prefix: left_")
    assert "left_gpio/standard_digital_output_cmd_17" in box.further_interfaces
    assert box.joints == ()
    activation = "robotiq_controllers/RobotiqActivationController"
    for name, prefix in (("left_activation", "left_"), ("activation", "")):
        assert parsed(activation, name=name).further_interfaces == (
            f"{prefix}reactivate_gripper/reactivate_gripper_cmd",
            f"{prefix}reactivate_gripper/reactivate_gripper_response",
        )
