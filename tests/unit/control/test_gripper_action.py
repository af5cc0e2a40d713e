import math

import pytest
from raises_naming import raises_naming
from toy_robot import DT, ToyRobot

from tool0.description.drive_limits import DriveLimits
from tool0.description.model import Interface, ParallelGripper, RotaryOpening
from tool0.errors import GoalRejectedError
from tool0.protocol.goals import GoalStatus

GRIPPER = """
hand:
  type: effort_controllers/GripperActionController
  joint: hip
  gains: {hip: {p: 400, d: 40}}
  goal_tolerance: 0.01
  max_effort: 8
  stall_velocity_threshold: 0.01
  stall_timeout: 0.2
"""


def hand(yaml: str = GRIPPER, interface: Interface = Interface.EFFORT):
    robot = ToyRobot(yaml, interface)
    return robot, robot.start("hand")


def target(controller) -> float:
    """Return the commanded position [rad]."""
    (position,) = controller.setpoint().target()
    return position


def test_succeeds_within_the_tolerance() -> None:
    robot, controller = hand()
    goal = controller.drive(0.5, 8.0, robot.time)
    while abs(0.5 - robot.position[1]) >= 0.01:
        robot.tick()
        assert goal.status is GoalStatus.ACTIVE
    robot.tick()
    assert goal.status is GoalStatus.SUCCEEDED
    assert goal.result.reached_goal
    assert not goal.result.stalled
    assert goal.result.position == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    ("own", "position", "effort", "commanded"),
    [
        (8, 0.5, 3.0, 3.0),
        (8, 0.5, -2.0, 2.0),
        (8, -0.5, 3.0, -3.0),
        (8, 0.5, 0.0, 8.0),
        (8, 0.5, None, 8.0),
        (None, 0.5, None, 50.0),
    ],
)
def test_the_goal_else_the_yaml_else_the_joint_bounds_the_effort(
    own, position, effort, commanded
) -> None:
    yaml = GRIPPER if own else GRIPPER.replace("max_effort: 8", "")
    robot, controller = hand(yaml)
    robot.blocked = {"hip"}
    controller.drive(position, effort, robot.time)
    robot.tick()
    assert robot.hardware.command[1] == commanded


@pytest.mark.parametrize("allow", ["false", "true"])
def test_a_stall_ends_the_goal_and_keeps_squeezing(allow: str) -> None:
    robot, controller = hand(GRIPPER + f"  allow_stalling: {allow}\n")
    robot.blocked = {"hip"}
    goal = controller.drive(0.5, 5.0, robot.time)
    robot.run(0.199)
    assert goal.status is GoalStatus.ACTIVE
    robot.run(0.004)
    wanted = GoalStatus.SUCCEEDED if allow == "true" else GoalStatus.ABORTED
    assert goal.status is wanted
    assert goal.result.stalled
    assert not goal.result.reached_goal
    assert goal.result.effort == 5.0
    robot.run(0.1)
    assert robot.hardware.command[1] == 5.0


@pytest.mark.parametrize(
    ("speed", "chatter", "stalls"),
    [(0.02, 0.0, False), (0.005, 0.0, True), (0.0, 5e-4, True)],
)
def test_a_slow_motion_and_chatter_are_stalls_below_the_threshold(
    speed: float, chatter: float, stalls: bool
) -> None:
    robot, controller = hand()
    robot.blocked = {"hip"}
    goal = controller.drive(0.5, 5.0, robot.time)
    for k in range(1000):
        robot.position[1] = speed * DT * k + chatter * (-1) ** k
        robot.velocity[1] = chatter / 5e-4 * (-1) ** k
        robot.tick()
    assert goal.status.is_terminal == stalls


def test_a_new_goal_preempts_and_restarts_the_clock() -> None:
    robot, controller = hand()
    robot.blocked = {"hip"}
    first = controller.drive(0.5, 5.0, robot.time)
    robot.run(0.15)
    second = controller.drive(0.6, 5.0, robot.time)
    assert first.status is GoalStatus.PREEMPTED
    robot.run(0.15)
    assert second.status is GoalStatus.ACTIVE


def test_a_cancel_holds_the_measured_position() -> None:
    robot, controller = hand()
    goal = controller.drive(0.5, 2.0, robot.time)
    robot.run(0.1)
    controller.cancel(goal, robot.time)
    assert goal.status is GoalStatus.PREEMPTED
    assert 0.0 < target(controller) < 0.5
    controller.cancel(goal, robot.time)
    robot.run(2.0)
    assert robot.position[1] == pytest.approx(target(controller), abs=1e-3)


def test_the_position_variant_commands_the_position() -> None:
    yaml = GRIPPER.replace("effort_controllers", "position_controllers")
    robot, controller = hand(yaml, Interface.POSITION)
    goal = controller.drive(0.5, None, robot.time)
    robot.run(0.003)
    assert robot.position[1] == 0.5
    assert goal.result.reached_goal


@pytest.mark.parametrize(
    ("position", "effort", "shown"),
    [(math.nan, 1.0, "nan"), (0.5, math.inf, "inf"), (6.5, 1.0, "[-6, 6]")],
)
def test_bad_goals_are_rejected_and_the_old_one_goes_on(
    position, effort, shown
) -> None:
    robot, controller = hand()
    goal = controller.drive(0.5, 2.0, robot.time)
    with raises_naming(GoalRejectedError, shown):
        controller.drive(position, effort, robot.time)
    assert goal.status is GoalStatus.ACTIVE
    assert target(controller) == 0.5


JAWS = ParallelGripper(
    name="jaws",
    joint="hip",
    law=RotaryOpening(pad_offset=0.0, pad_cos=0.0, pad_sin=-0.5),
    max_opening=1.0,
    speed=(0.1, 1.0),
    force=(1.0, 100.0),
)
"""Its lever is cos q [m/rad]."""


def test_at_a_bounded_speed_an_integral_does_not_wind_up() -> None:
    gains = "{p: 400, d: 40, i: 100, i_clamp: 100}"
    robot, controller = hand(GRIPPER.replace("{p: 400, d: 40}", gains))
    slow = DriveLimits(gripper=JAWS, speed=0.2)
    goal = controller.drive(0.5, None, robot.time, slow)
    start = robot.time
    while goal.result is None:
        robot.tick()
        assert robot.position[1] <= 0.2 / math.cos(0.5) * (robot.time - start) + 1e-3
    assert goal.status is GoalStatus.SUCCEEDED
    overshoot = 0.0
    for _ in range(1000):
        robot.tick()
        overshoot = max(overshoot, robot.position[1] - 0.5)
    assert overshoot < 0.03


def test_a_firmer_squeeze_does_not_let_go_and_opening_does() -> None:
    robot, controller = hand()
    robot.blocked = {"hip"}
    slow = DriveLimits(gripper=JAWS, speed=0.1)
    controller.drive(0.5, None, robot.time)
    robot.tick()
    assert robot.hardware.command[1] == 8.0
    controller.drive(0.5, None, robot.time, slow)
    robot.tick()
    assert robot.hardware.command[1] == 8.0
    controller.drive(0.01, None, robot.time, slow)
    robot.tick()
    assert robot.hardware.command[1] == pytest.approx(400 * 0.01)
    controller.drive(-0.5, None, robot.time, slow)
    robot.tick()
    assert -0.1 < robot.hardware.command[1] < 0.0
