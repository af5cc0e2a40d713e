"""A robot with ROS 2's drives and controllers, in Python."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from raises_naming import raises_naming

import tool0
from tool0.errors import ConfigError, ControlError, GoalRejectedError
from tool0.protocol.controllers import ReadControllerParameters, SetControllerParameters
from tool0.protocol.gripper import ReactivateGripper

HAND, ARM = "robotiq_gripper_controller", "joint_trajectory_controller"
SCALED = "scaled_joint_trajectory_controller"
PASSTHROUGH = "passthrough_trajectory_controller"
MODES = ("freedrive_mode_controller", "force_mode_controller")


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5e", ros2_control=True, realtime=False) as robot:
        yield robot


def parameter(robot: tool0.Robot, controller: str, name: str) -> object:
    found = robot.channel.call(ReadControllerParameters(controller=controller))
    return found[name].value


def test_it_starts_what_the_driver_starts(robot: tool0.Robot) -> None:
    assert robot.warnings == ()
    assert robot.control_period == 1 / 500
    states = {status.name: status.state for status in robot.controllers()}
    assert {states.pop(name) for name in (SCALED, PASSTHROUGH, *MODES)} == {"inactive"}
    assert set(states.values()) == {"active"}
    assert {ARM, HAND, "io_and_status_controller", "tcp_pose_broadcaster"} <= set(
        states
    )


def test_the_scaled_controller_says_how_to_start_it(robot: tool0.Robot) -> None:
    """Examples of UR's driver use it."""
    with raises_naming(GoalRejectedError, f"switch --stop {ARM} --start {SCALED}"):
        robot.controller(SCALED).move({"elbow_joint": 0.1})
    robot.switch(start=[SCALED], stop=[ARM])
    robot.switch(start=[ARM], stop=[SCALED])


def test_arm_and_gripper_move_as_ever(robot: tool0.Robot) -> None:
    goals = robot.move_joints({"elbow_joint": 0.5})
    grip = robot.gripper.move(opening=0.03, speed=0.1, force=20.0)
    assert all(goal.wait(10.0).status is tool0.GoalStatus.SUCCEEDED for goal in goals)
    assert grip.wait(10.0).status is tool0.GoalStatus.SUCCEEDED
    robot.run(0.5)
    assert robot.gripper.opening == pytest.approx(0.03, abs=2e-3)
    assert robot.joint_state.position["elbow_joint"] == pytest.approx(0.5, abs=1e-2)


def test_a_goal_sets_the_speed_of_the_pads(robot: tool0.Robot) -> None:
    def time_to_close(speed: float) -> float:
        robot.controller(HAND).command_gripper(0.0).wait(5.0)
        robot.run(0.5)
        start = robot.time
        robot.controller(HAND).command_gripper(0.6, max_velocity=speed).wait(20.0)
        return robot.time - start

    fast, slow = time_to_close(0.1), time_to_close(0.025)
    assert slow == pytest.approx(4.0 * fast, rel=0.3)


def test_a_cancel_holds_where_it_is(robot: tool0.Robot) -> None:
    hand = robot.controller(HAND)
    hand.command_gripper(0.0).wait(5.0)
    goal = hand.command_gripper(0.7, max_velocity=0.02)
    robot.run(0.5)
    goal.cancel()
    assert goal.wait(1.0).status is tool0.GoalStatus.PREEMPTED
    held = robot.joint_state.position["finger_joint"]
    robot.run(1.0)
    assert robot.joint_state.position["finger_joint"] == pytest.approx(held, abs=0.02)
    assert 0.05 < held < 0.5


def test_an_activation_opens_the_gripper(robot: tool0.Robot) -> None:
    robot.gripper.move(opening=0.02).wait(5.0)
    activate = ReactivateGripper(controller="robotiq_activation_controller")
    assert robot.channel.call(activate).controller == HAND
    robot.run(2.0)
    assert robot.gripper.opening == pytest.approx(0.085, abs=1e-3)
    for name, shown in ((ARM, "activates no gripper"), ("nobody", "not loaded")):
        with raises_naming(ControlError, name, shown):
            robot.channel.call(ReactivateGripper(controller=name))


def test_parameters_are_read_and_set_by_requests(robot: tool0.Robot) -> None:
    assert parameter(robot, ARM, "constraints.goal_time") == 0.0
    robot.channel.call(
        SetControllerParameters(
            controller=ARM,
            parameters={
                "constraints.goal_time": 0.6,
                "allow_partial_joints_goal": True,
            },
        )
    )
    assert parameter(robot, ARM, "constraints.goal_time") == 0.6
    assert robot.move_joints({"elbow_joint": 0.2})[0].wait(10.0).error_code == 0
    for value in ("none", ["elbow_joint"], [1, 2.0]):
        with raises_naming(ControlError, "'joints'", "read-only"):
            robot.channel.call(
                SetControllerParameters(controller=ARM, parameters={"joints": value})
            )


def test_variables_of_a_yaml_are_arguments_of_the_robot(tmp_path: Path) -> None:
    """As in UR's driver, whose launch file allows substitutions."""
    file = tmp_path / "mine.yaml"
    forward = "forward_command_controller/ForwardCommandController"
    file.write_text(
        "shoulder:\n  ros__parameters:\n"
        f"    type: {forward}\n    interface_name: position\n"
        "    joints: [$(var tf_prefix)$(var prefix)shoulder_pan_joint]\n"
    )
    with tool0.bringup(
        args={"prefix": "left_"},
        ros2_control=True,
        controllers_file=file,
        controllers="shoulder",
        realtime=False,
    ) as robot:
        (status,) = robot.controllers()
        assert status.joints == {"left_shoulder_pan_joint"}


def test_a_yaml_of_ones_own_replaces_them_with_its_rate(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    forward = "forward_command_controller/ForwardCommandController"
    text = (
        "controller_manager:\n  ros__parameters:\n    update_rate: 250\n"
        f"    shoulder: {{type: {forward}}}\n"
        "shoulder:\n  ros__parameters:\n    interface_name: position\n"
        "    joints: [shoulder_pan_joint]\n    colour: red\n"
    )
    file.write_text(text)

    def bringup(period: float | None = None) -> tool0.Robot:
        control = tool0.ControlConfig(control_period=period)
        return tool0.bringup(
            ros2_control=True,
            controllers_file=file,
            controllers="shoulder",
            control=control,
            realtime=False,
        )

    with bringup() as robot:
        assert robot.control_period == 1 / 250
        assert [f"{file}:9" in warning for warning in robot.warnings] == [True]
        robot.controller("shoulder").command([0.4])
        robot.run(1.0)
        pan = robot.joint_state.position["shoulder_pan_joint"]
        assert pan == pytest.approx(0.4, abs=1e-3)
    with bringup(period=0.001) as robot:
        assert robot.control_period == 0.001
    file.write_text(text.replace("250", "300"))
    with raises_naming(ConfigError, "update_rate 300 Hz", "step 0.001"):
        bringup()
