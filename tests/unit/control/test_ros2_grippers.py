from __future__ import annotations

import math

import pytest
from raises_naming import raises_naming
from toy_robot import JOINTS, ToyHardware, ToyRobot

from tool0.control.config import ControllerConfig
from tool0.control.gripper_action import GripperActionController
from tool0.control.manager import ControllerManager
from tool0.description.hardware_component import (
    HardwareComponent,
    HardwareInterface,
    HardwareItem,
)
from tool0.description.model import (
    Interface,
    LinearOpening,
    ParallelGripper,
    RobotModel,
)
from tool0.errors import ConfigError, GoalRejectedError
from tool0.hardware.engine import JointState
from tool0.protocol.goals import GoalStatus, GripperResult

PARALLEL = "parallel_gripper_action_controller/GripperActionController"
PADS = "slide/set_gripper_max_"


def yaml(**parameters: object) -> str:
    given = {"type": PARALLEL, "joint": "slide", **parameters}
    lines = [f"    {name}: {value}" for name, value in given.items()]
    return "\n".join(["c:", "  ros__parameters:", *lines])


def started(**parameters: object) -> tuple[ToyRobot, GripperActionController]:
    robot = ToyRobot(yaml(**parameters), Interface.POSITION)
    controller = robot.start("c")
    assert isinstance(controller, GripperActionController)
    return robot, controller


def gripper() -> ParallelGripper:
    """Return a gripper that closes by 2 m for 1 m of ``slide``."""
    return ParallelGripper(
        name="hand",
        joint="slide",
        law=LinearOpening(pad_offset=0.05, pad_slope=-1.0),
        max_opening=0.1,
        speed=(0.02, 0.2),
        force=(5.0, 60.0),
    )


def with_hardware(**parameters: object) -> GripperActionController:
    """Return the controller of a robot with a gripper and its hardware."""
    commands = ("position", "set_gripper_max_effort", "set_gripper_max_velocity")
    hand = HardwareItem(
        kind="joint",
        name="slide",
        commands=tuple(map(named, (*commands, "effort", "velocity"))),
        states=(named("position"), named("velocity")),
    )
    model = RobotModel(
        name="toy",
        root="x",
        links=(),
        joints=tuple(JOINTS.values()),
        grippers=(gripper(),),
        hardware=(
            HardwareComponent(name="h", type="system", plugin="p", items=(hand,)),
        ),
    )
    config = ControllerConfig.from_text(yaml(**parameters))
    hardware = ToyHardware(Interface.POSITION)
    manager = ControllerManager(hardware, config, JOINTS, model)
    manager.load("c")
    spec = manager.spec("c")
    robot = ToyRobot(yaml(**parameters), Interface.POSITION)
    controller = spec.start([2], robot.state)
    assert isinstance(controller, GripperActionController)
    return controller


def named(name: str) -> HardwareInterface:
    return HardwareInterface(name=name)


def result(goal: object) -> GripperResult:
    outcome = goal.result
    assert isinstance(outcome, GripperResult)
    return outcome


def test_it_arrives_and_keeps_its_command() -> None:
    robot, controller = started(goal_tolerance=0.01)
    goal = controller.drive(0.05, None, robot.time)
    robot.run(0.01)
    assert goal.status is GoalStatus.SUCCEEDED
    assert result(goal).reached_goal
    assert not result(goal).stalled
    robot.run(0.5)
    assert robot.position[2] == 0.05


@pytest.mark.parametrize("allowed", [False, True])
def test_a_stall_ends_a_goal_in_success_if_it_is_allowed(allowed: bool) -> None:
    robot, controller = started(stall_timeout=0.05, allow_stalling=str(allowed).lower())
    robot.blocked.add("slide")
    goal = controller.drive(0.05, None, robot.time)
    robot.run(0.045)
    assert goal.status is GoalStatus.ACTIVE
    robot.run(0.01)
    expected = GoalStatus.SUCCEEDED if allowed else GoalStatus.ABORTED
    assert goal.status is expected
    assert result(goal).stalled
    assert not result(goal).reached_goal


def test_a_gripper_whose_state_is_late_does_not_stall_before_it_moves() -> None:
    text = yaml(stall_timeout=0.05, allow_stalling="true")
    robot = ToyRobot(text, Interface.POSITION, gripper_delay=0.3)
    controller = robot.start("c")
    assert isinstance(controller, GripperActionController)
    robot.blocked.add("slide")
    goal = controller.drive(0.05, None, robot.time)
    robot.run(0.345)
    assert goal.status is GoalStatus.ACTIVE
    robot.blocked.clear()
    robot.run(0.2)
    assert result(goal).reached_goal
    robot.blocked.add("slide")
    goal = controller.drive(0.0, None, robot.time)
    robot.run(0.36)
    assert result(goal).stalled


def test_the_result_is_what_is_measured_at_the_end() -> None:
    controller = with_hardware(goal_tolerance=0.01)
    goal = controller.drive(0.05, None, 0.0)
    position, effort = [0.0, 0.0, 0.045, 0.0], [0.0, 0.0, 7.0, 0.0]
    controller.update(JointState(0.1, position, [0.0] * 4, effort), 0.001)
    assert result(goal).reached_goal
    assert (result(goal).position, result(goal).effort) == (0.045, 7.0)


def test_a_cancel_holds_the_measured_position() -> None:
    robot, controller = started()
    robot.blocked.add("slide")
    goal = controller.drive(0.5, None, robot.time)
    robot.tick()
    controller.cancel(goal, robot.time)
    assert goal.status is GoalStatus.PREEMPTED
    robot.blocked.clear()
    robot.run(0.1)
    assert robot.position[2] == 0.0


def test_a_new_goal_preempts_and_a_wrong_one_is_rejected() -> None:
    robot, controller = started()
    first = controller.drive(0.5, None, robot.time)
    for position in (math.nan, 7.0):
        with pytest.raises(GoalRejectedError):
            controller.drive(position, None, robot.time)
    assert first.status is GoalStatus.ACTIVE
    controller.drive(0.2, None, robot.time)
    assert first.status is GoalStatus.PREEMPTED


def test_settings_of_the_pads_are_the_nearest_that_the_gripper_has() -> None:
    pads = {
        "max_effort_interface": f"{PADS}effort",
        "max_velocity_interface": f"{PADS}velocity",
        "max_effort": 50.0,
        "max_velocity": 0.5,
    }
    controller = with_hardware(**pads)
    assert controller.spec.further_interfaces == (f"{PADS}effort", f"{PADS}velocity")
    default = controller.limits(None, None)
    assert default is not None
    assert (default.force, default.speed, default.effort) == (50.0, 0.2, None)
    given = controller.limits(1.0, 0.1)
    assert given is not None
    assert (given.force, given.speed) == (5.0, 0.1)


def test_settings_of_the_joint_are_converted_with_its_lever() -> None:
    controller = with_hardware(
        max_effort_interface="slide/effort", max_velocity_interface="slide/velocity"
    )
    limits = controller.limits(8.0, 0.05)
    assert limits is not None
    assert (limits.effort, limits.force, limits.speed) == (8.0, None, 0.1)


def test_without_interfaces_the_drive_has_its_all() -> None:
    assert with_hardware().limits(8.0, 0.05) is None
    only = with_hardware(max_velocity_interface="slide/velocity").limits(8.0, 0.05)
    assert only is not None
    assert (only.effort, only.force) == (None, None)


def test_an_interface_that_the_hardware_lacks_is_refused() -> None:
    with raises_naming(ConfigError, ":5", "'slide/effort'", "did you mean"):
        with_hardware(max_effort_interface="slide/efort")


@pytest.mark.parametrize(
    ("parameters", "shown"),
    [
        ({"joint": "idle"}, "no <transmission>"),
        ({"goal_tolerance": -1.0}, "0 or more"),
        ({"action_monitor_rate": 0.0}, "at least 0.1"),
        ({"allow_stalling": "perhaps"}, "true or false"),
    ],
)
def test_wrong_parameters_are_refused(
    parameters: dict[str, object], shown: str
) -> None:
    with raises_naming(ConfigError, "<string>:", shown):
        started(**parameters)


def test_humbles_gripper_squeezes_by_effort() -> None:
    text = yaml(
        type="effort_controllers/GripperActionController",
        **{"gains.slide.p": 400.0, "gains.slide.d": 40.0, "max_effort": 3.0},
    )
    robot = ToyRobot(text, Interface.EFFORT)
    controller = robot.start("c")
    robot.blocked.add("slide")
    controller.drive(0.5, 2.0, robot.time)
    robot.tick()
    assert robot.hardware.command[2] == 2.0
    controller.drive(0.5, None, robot.time)
    robot.tick()
    assert robot.hardware.command[2] == 3.0
