"""Parameters of controllers as nodes have them, and changes of them."""

from __future__ import annotations

import pytest
from raises_naming import raises_naming
from toy_robot import ToyRobot

from tool0.control.ros2.dialect import ROS2
from tool0.description.model import Interface
from tool0.errors import ControlError

TEXT = """
hand:
  ros__parameters:
    type: parallel_gripper_action_controller/GripperActionController
    joint: slide
    stall_timeout: 0.5
    colour: red
squeeze:
  ros__parameters:
    type: effort_controllers/GripperActionController
    joint: slide
    gains: {slide: {p: 400.0, d: 40.0}}
bare:
  ros__parameters: {type: forward_command_controller/ForwardCommandController}
"""


def test_all_have_values_defaults_included() -> None:
    robot = ToyRobot(TEXT, Interface.POSITION)
    robot.manager.load("hand", configure=False)
    values = robot.manager.parameters("hand").values
    assert values["stall_timeout"] == 0.5
    assert values["colour"] == "red"  # nothing reads it; the node has it all the same
    assert values["goal_tolerance"] == 0.01
    assert values["max_effort_interface"] == ""
    assert values["state_interfaces"] == ("position", "velocity")


def test_a_controller_that_cannot_be_configured_has_those_given() -> None:
    robot = ToyRobot(TEXT, Interface.POSITION)
    robot.manager.load("bare", configure=False)
    assert set(robot.manager.parameters("bare").values) == {"type"}


def test_a_running_controller_continues_with_what_is_set() -> None:
    robot = ToyRobot(TEXT, Interface.POSITION)
    controller = robot.start("hand")
    robot.blocked.add("slide")
    robot.manager.set_parameters("hand", {"stall_timeout": 0.02})
    assert robot.manager.parameters("hand").values["stall_timeout"] == 0.02
    goal = controller.drive(0.5, None, robot.time)
    robot.run(0.03)
    assert goal.status.is_terminal


def test_gains_are_parameters_too() -> None:
    robot = ToyRobot(TEXT, Interface.EFFORT)
    controller = robot.start("squeeze")
    controller.drive(0.1, 0.0, robot.time)
    robot.manager.set_parameters("squeeze", {"gains.slide.p": 100.0})
    robot.tick()
    assert robot.hardware.command[2] == pytest.approx(10.0)
    assert robot.manager.spec("squeeze").gains[0].d == 40.0


@pytest.mark.parametrize(
    ("name", "value", "shown"),
    [
        ("joint", "hip", "read-only; these can be set: allow_stalling, goal_t"),
        ("goal_tolerance", 1, "{double}; setting it to {integer} 1"),
        ("goal_tolerance", "far", "{string}"),
        ("goal_tolerance", -1.0, "0 or more"),
        ("goal_tolerence", 0.1, "'goal_tolerance'"),
        ("max_velocity", True, "{bool}"),
    ],
)
def test_a_refused_change_says_why_and_changes_nothing(
    name: str, value: object, shown: str
) -> None:
    robot = ToyRobot(TEXT, Interface.POSITION)
    robot.start("hand")
    before = robot.manager.parameters("hand").values
    with raises_naming(ControlError, "hand", name, shown):
        robot.manager.set_parameters("hand", {"stall_timeout": 0.02, name: value})
    assert robot.manager.parameters("hand").values == before


@pytest.mark.parametrize("kind", sorted(ROS2.types))
def test_every_type_reads_its_sample(kind: str) -> None:
    values = ROS2.values_of(kind)
    assert values.keys() <= ROS2.parameters_of(kind)
    assert values or "Activation" in kind
