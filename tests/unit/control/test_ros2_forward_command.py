from __future__ import annotations

import math

import pytest
from raises_naming import raises_naming
from toy_robot import ToyRobot

from tool0.control.forward_command import ForwardCommandController
from tool0.description.model import Interface
from tool0.errors import ConfigError, ControlError

FORWARD = "forward_command_controller/ForwardCommandController"
MULTI = "forward_command_controller/MultiInterfaceForwardCommandController"


def robot_with(parameters: str, interface: Interface) -> ToyRobot:
    return ToyRobot(f"c:\n  ros__parameters: {{{parameters}}}", interface)


def started(
    interface: Interface, parameters: str = ""
) -> tuple[ToyRobot, ForwardCommandController]:
    kind = interface.name.lower()
    robot = robot_with(
        parameters or f"type: {FORWARD}, joints: [wheel, hip], interface_name: {kind}",
        interface,
    )
    robot.position = [0.1, 0.2, 0.3, 0.4]
    controller = robot.start("c")
    assert isinstance(controller, ForwardCommandController)
    return robot, controller


@pytest.mark.parametrize("interface", list(Interface))
def test_it_forwards_in_the_order_of_its_joints(interface: Interface) -> None:
    robot, controller = started(interface)
    (status,) = robot.manager.list()
    kind = interface.name.lower()
    assert status.command_interfaces == (f"wheel/{kind}", f"hip/{kind}")
    robot.tick()
    still = [0.0, 0.2, 0.0, 0.4] if kind == "position" else [0.0] * 4
    assert robot.hardware.command == still
    controller.command_joints([1.0, 2.0])
    robot.tick()
    assert robot.hardware.command == [0.0, 2.0, 0.0, 1.0]


def test_nothing_is_written_to_efforts_before_the_first_command() -> None:
    robot, controller = started(Interface.EFFORT)
    assert robot.hardware.claimed == []  # the brakes hold
    controller.command_joints([1.0, 2.0])
    robot.manager.release_brakes("c", robot.state)
    assert robot.hardware.claimed == ["wheel", "hip"]


@pytest.mark.parametrize(
    ("values", "shown"),
    [([1.0], "(1)"), ([1.0] * 3, "(3)"), ([1.0, math.nan], "nan for joint 'hip'")],
)
def test_a_bad_command_is_refused_and_changes_nothing(
    values: list[float], shown: str
) -> None:
    robot, controller = started(Interface.VELOCITY)
    controller.command_joints([3.0, 4.0])
    with raises_naming(ControlError, shown):
        controller.command_joints(values)
    robot.tick()
    assert robot.hardware.command == [0.0, 4.0, 0.0, 3.0]


@pytest.mark.parametrize("interface", list(Interface))
def test_a_group_has_the_interface_of_its_package(interface: Interface) -> None:
    kind = interface.name
    group = f"{kind.lower()}_controllers/JointGroup{kind.title()}Controller"
    robot, controller = started(interface, f"type: {group}, joints: [slide]")
    controller.command_joints([0.5])
    robot.tick()
    assert robot.hardware.command[2] == 0.5


def test_only_commanded_positions_are_setpoints() -> None:
    _, controller = started(Interface.POSITION)
    assert controller.setpoint() is None
    controller.command_joints([1.0, 2.0])
    setpoint = controller.setpoint()
    assert setpoint is not None
    assert list(setpoint.state().desired.positions) == [1.0, 2.0]
    assert started(Interface.VELOCITY)[1].setpoint() is None


@pytest.mark.parametrize(
    ("parameters", "shown"),
    [
        (f"type: {FORWARD}, interface_name: position", "lacks 'joints'"),
        (f"type: {FORWARD}, joints: [hip]", "lacks 'interface_name'"),
        (f"type: {FORWARD}, joints: [hip, hip], interface_name: position", "twice"),
        (f"type: {FORWARD}, joints: [hipp], interface_name: position", "'hip'"),
        (f"type: {FORWARD}, joints: [hip], interface_name: positon", "'position'"),
        (f"type: {FORWARD}, joints: [hip], interface_name: velocity", "offers"),
        (f"type: {MULTI}, joint: hip, interface_names: [position, velocity]", "one"),
    ],
)
def test_wrong_parameters_are_refused(parameters: str, shown: str) -> None:
    with raises_naming(ConfigError, "<string>:", shown):
        robot_with(parameters, Interface.POSITION).manager.load("c")


def test_one_interface_of_one_joint_is_enough() -> None:
    parameters = f"type: {MULTI}, joint: hip, interface_names: [position]"
    robot, controller = started(Interface.POSITION, parameters)
    controller.command_joints(0.7)
    robot.tick()
    assert robot.hardware.command[1] == 0.7
