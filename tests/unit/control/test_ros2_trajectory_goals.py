"""What ROS 2's JointTrajectoryController refuses: goals, messages and parameters."""

from __future__ import annotations

import math

import msgspec
import pytest
from ros2_arm import NAMES, REST, Point, arm, goal, yaml
from toy_robot import ToyRobot

from tool0.control.config import ControllerConfig
from tool0.description.model import Interface
from tool0.errors import ConfigError, GoalRejectedError
from tool0.protocol.controllers import UNLIMITED, Gains, Unwinding

THERE = Point([0.1, 0.1, 0.1], REST, time_from_start=1.0)


@pytest.mark.parametrize(
    ("refused", "why"),
    [
        (goal(THERE, joint_names=["hip", "slide"]), "don't match the controller"),
        (goal(THERE, joint_names=["hip", "slide", "w"]), "Incoming joint w doesn't"),
        (goal(THERE, joint_names=["hip", "hip", "slide"]), "hip is named twice"),
        (goal(), "Empty trajectory received"),
        (
            goal(Point(REST, [0, 0.5, 0], time_from_start=1.0)),
            "Velocity of last trajectory point of joint slide is not zero: 0.5000",
        ),
        (goal(THERE, stamp=0.5), r"start time \(0.500000\) that ends in the past"),
        (goal(THERE, stamp=math.nan), "stamp nan"),
        (
            goal(THERE, Point(REST, time_from_start=1.0)),
            "Time between points 0 and 1 is not strictly increasing, it is 1.000000",
        ),
        (goal(Point(REST, time_from_start=math.inf)), "point 0 has time_from_start"),
        (
            goal(Point([0, 0], time_from_start=1.0)),
            r"Mismatch between joint_names size \(3\) and positions \(2\) at point #0",
        ),
        (
            goal(Point(REST, None, [0, 0], time_from_start=1.0)),
            r"Mismatch .* and accelerations \(2\) at point #0",
        ),
        (goal(Point([], REST, time_from_start=1.0)), r"and positions \(0\)"),
        (goal(Point([0, math.nan, 0], time_from_start=1.0)), "must be finite"),
        (goal(Point([7, 0, 0], time_from_start=1.0)), "beyond its limits"),
        (goal(Point([1, 0, 0], time_from_start=1e-12)), "no joint can move"),
    ],
)
def test_refuses(refused, why: str) -> None:
    robot, controller = arm()
    robot.run(2.0)
    active = controller.follow(goal(Point(REST, time_from_start=9.0)), robot.time)
    for send in (controller.follow, controller.command):
        with pytest.raises(GoalRejectedError, match=why):
            send(refused, robot.time)
    assert active.result is None
    robot.run(0.1)
    assert robot.position[1:] == REST


def test_refuses_empty_names_also_where_partial_goals_are_allowed() -> None:
    _, controller = arm({"allow_partial_joints_goal": "true"})
    with pytest.raises(GoalRejectedError, match="Empty joint names"):
        controller.follow(goal(THERE, joint_names=[]), 0.0)


def test_an_end_in_motion_is_accepted_where_a_parameter_allows_it() -> None:
    _robot, controller = arm({"allow_nonzero_velocity_at_trajectory_end": "true"})
    controller.follow(goal(Point(REST, [0, 0.5, 0], time_from_start=1.0)), 0.0)


def test_integration_needs_something_to_integrate() -> None:
    _, controller = arm({"allow_integration_in_goal_trajectories": "true"})
    with pytest.raises(GoalRejectedError, match="no position, velocity, or accel"):
        controller.follow(goal(Point([], time_from_start=1.0)), 0.0)
    far = Point([], [100.0, 0, 0], time_from_start=1.0)
    end = Point([], REST, time_from_start=2.0)
    with pytest.raises(GoalRejectedError, match="beyond its limits"):
        controller.follow(goal(far, end), 0.0)


# ---- parameters --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "line", "why"),
    [
        ({"joints": "[hip, hop, wheel]"}, 4, "'hop'"),
        ({"joints": "[hip, hip, wheel]"}, 4, "names joint 'hip' twice"),
        ({"joints": "[]"}, 4, "must be a list of names"),
        ({"command_interfaces": "[torque]"}, 5, "not an interface type"),
        ({"command_interfaces": "[position, position]"}, 5, "'position' twice"),
        ({"command_interfaces": "[velocity, effort]"}, 5, r"cannot be \[velocity, ef"),
        ({"command_interfaces": "[acceleration]"}, 5, r"cannot be \[acceleration\]"),
        ({"command_interfaces": "[velocity]"}, 4, "Velocity"),
        ({"state_interfaces": "[velocity]"}, 6, "lacks 'position'"),
        ({"state_interfaces": "[position, acceleration]"}, 6, "no state interface"),
        ({"command_joints": "[hip]"}, None, "same joints as 'joints'"),
        ({"interpolation_method": "spline"}, None, "did you mean 'splines'"),
        ({"gains.hip.antiwindup_strategy": "some"}, None, "cannot be 'some'"),
        ({"gains.hip.u_clamp_min": 1.0}, None, "u_min <= 0"),
        ({"action_monitor_rate": 0.0}, None, "at least 0.1"),
        ({"constraints.goal_time": -1.0}, 7, "0 or more"),
        ({"constraints.hip.goal": "near"}, None, "must be a number"),
        ({"speed_scaling.initial_scaling_factor": -1.0}, None, "0 or more"),
        ({"speed_scaling.state_interface": "speed/factor"}, None, "no state interface"),
        ({"allow_partial_joints_goal": 1}, None, "true or false"),
    ],
)
def test_wrong_parameters_are_errors_with_their_line(changes, line, why) -> None:
    text = yaml(Interface.POSITION, changes)
    robot = ToyRobot(text, Interface.POSITION)
    with pytest.raises(ConfigError, match=why) as caught:
        robot.start("arm")
    location = caught.value.location
    assert location is not None
    if line is not None:
        assert location.line == line


def test_velocities_and_efforts_need_both_states() -> None:
    changes = {"state_interfaces": "[position]"}
    for interface in (Interface.VELOCITY, Interface.EFFORT):
        with pytest.raises(ConfigError, match="command interface can only be used"):
            arm(changes, interface)


def test_gains_have_the_defaults_of_ros_2() -> None:
    _, controller = arm({"gains.hip.i_clamp": "3.0"}, Interface.VELOCITY)
    hip, slide, _ = controller.spec.gains
    assert (hip.p, hip.i, hip.i_min, hip.i_max) == (20.0, 0.0, -3.0, 3.0)
    assert (slide.i_min, slide.i_max) == (-UNLIMITED, UNLIMITED)
    assert slide.antiwindup
    assert msgspec.json.decode(msgspec.json.encode(slide), type=Gains) == slide


def test_the_newer_clamps_win_over_the_symmetric_one() -> None:
    changes = {"gains.hip.i_clamp": "3.0", "gains.hip.i_clamp_max": "1.0"}
    changes["gains.slide.i_clamp_max"] = ".inf"
    _, controller = arm(changes, Interface.EFFORT)
    hip, slide, _ = controller.spec.gains
    assert (hip.i_min, hip.i_max) == (-3.0, 1.0)
    assert (slide.i_min, slide.i_max) == (-1.0, 1.0)


def test_the_command_of_a_pid_can_be_limited() -> None:
    limits = {"gains.hip.u_clamp_max": 0.1, "gains.hip.u_clamp_min": -0.1}
    limits["gains.hip.antiwindup_strategy"] = "conditional_integration"
    limits["gains.hip.ff_velocity_scale"] = 0.0  # it comes on top
    robot, controller = arm(limits, Interface.VELOCITY)
    robot.blocked = {"hip"}
    free = {"path_tolerance": dict.fromkeys(NAMES, -1.0)}
    controller.follow(goal(Point([1, 1, 1], REST, time_from_start=1.0), **free), 0.0)
    robot.run(0.5)
    assert robot.hardware.command[1] == 0.1
    assert controller.spec.gains[0].unwinding is Unwinding.CONDITIONAL_INTEGRATION


@pytest.mark.parametrize(
    ("gains", "seconds"),
    [
        ({"tracking_time_constant": 0.3}, 0.3),
        ({"p": 8.0, "i": 2.0}, 4.0),
        ({"p": 8.0, "i": 2.0, "d": 0.5}, 0.5),
        ({"p": 8.0}, 1.0),
    ],
)
def test_the_tracking_time_has_the_default_of_control_toolbox(
    gains: dict[str, float], seconds: float
) -> None:
    changes = {f"gains.hip.{gain}": value for gain, value in gains.items()}
    changes["gains.hip.antiwindup_strategy"] = "back_calculation"
    _, controller = arm(changes, Interface.VELOCITY)
    assert controller.spec.gains[0].tracking_time == seconds


def test_an_open_loop_passes_the_desired_velocities_on() -> None:
    changes = {f"gains.{name}.p": 100.0 for name in NAMES}
    robot, controller = arm(
        {**changes, "open_loop_control": "true"}, Interface.VELOCITY
    )
    robot.blocked = {"hip"}
    free = {"path_tolerance": dict.fromkeys(NAMES, -1.0)}
    controller.follow(goal(Point([1, 1, 1], time_from_start=2.0), **free), 0.0)
    robot.run(0.5)
    assert robot.hardware.command[1] == 0.5


def test_parameters_may_change_while_it_runs() -> None:
    robot, controller = arm()
    robot.manager.set_parameters(
        "arm", {"constraints.hip.trajectory": 0.3, "allow_partial_joints_goal": True}
    )
    robot.blocked = {"hip"}
    point = Point([0.5], [0.0], time_from_start=0.5)
    handle = controller.follow(goal(point, joint_names=["hip"]), robot.time)
    robot.run(0.2)
    assert handle.result is None  # the error is 0.18
    robot.run(0.2)
    assert handle.result is not None


def test_every_parameter_can_be_read() -> None:
    robot, _ = arm()
    values = robot.manager.parameters("arm").values
    assert values["command_interfaces"] == ("position",)
    assert values["constraints.goal_time"] == 0.5
    assert values["allow_trajectory_replacement"] is True
    assert values["interpolation_method"] == "splines"
    assert values["gains.hip.ff_velocity_scale"] == 0.0


def test_the_linter_knows_every_parameter() -> None:
    for changes in ({}, {"type": "ur_controllers/ScaledJointTrajectoryController"}):
        config = ControllerConfig.from_text(yaml(Interface.POSITION, changes))
        assert not [each for each in config.lint(NAMES) if "no_such" not in each.rule]
