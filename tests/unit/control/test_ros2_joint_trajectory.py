"""ROS 2's JointTrajectoryController: how goals start, end and replace each other."""

import logging

import pytest
from ros2_arm import NAMES, REST, Point, arm, goal
from toy_robot import DT

from tool0.control.spline import Motion, Segment, along
from tool0.control.trajectory_monitor import REACHED
from tool0.description.model import Interface
from tool0.errors import ControlError
from tool0.protocol.goals import GoalResult, GoalStatus, Tolerance

AT_ONCE = {"allow_trajectory_replacement": "false"}
PARTIAL = {"allow_partial_joints_goal": "true"}
REPLACED = GoalResult(
    status=GoalStatus.ABORTED,
    error_code=-1,
    error_string="Current goal preempted by new incoming action.",
)


def desired(controller, time: float):
    return controller.query_state(time).positions


# ---- following ---------------------------------------------------------------------


@pytest.mark.parametrize("interface", list(Interface))
def test_follows_a_trajectory_through_every_interface(interface: Interface) -> None:
    robot, controller = arm(interface=interface)
    handle = controller.follow(
        goal(
            Point([0.5, -0.2, 1.0], [0.5, 0.0, 1.0], time_from_start=1.0),
            Point([1.0, -0.4, 2.0], REST, time_from_start=2.0),
        ),
        robot.time,
    )
    robot.run(1.99)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.1)
    assert handle.result == REACHED
    assert robot.position[1:] == pytest.approx([1.0, -0.4, 2.0], abs=0.01)


def test_positions_beside_velocities_are_commanded_as_positions() -> None:
    changes = {"command_interfaces": "[position, velocity]"}
    robot, controller = arm(changes)
    status = robot.manager.status("arm")
    assert status.claimed[0][0] == Interface.POSITION.value
    assert status.command_interfaces[-1] == "wheel/velocity"
    controller.follow(goal(Point([1, 1, 1], REST, time_from_start=1.0)), 0.0)
    robot.run(1.0)
    assert robot.position[1:] == [1.0, 1.0, 1.0]


def test_the_command_is_one_period_ahead_of_what_errors_are_against() -> None:
    robot, controller = arm()
    controller.follow(goal(Point([1, 1, 1], time_from_start=1.0)), 0.0)
    robot.run(0.25)
    assert robot.hardware.command[1] == pytest.approx(0.25)
    assert robot.position[1] == pytest.approx(0.25)
    state = controller.setpoint().state()
    assert state.time == pytest.approx(0.249)
    assert state.desired.positions[0] == pytest.approx(0.249)
    assert state.error.positions == pytest.approx(REST, abs=1e-12)


def test_the_feed_forward_scales_the_velocity_one_period_ahead() -> None:
    def command(scale: float) -> float:
        changes = {f"gains.{name}.ff_velocity_scale": scale for name in NAMES}
        robot, controller = arm(changes, Interface.EFFORT)
        controller.follow(goal(Point([1, 1, 1], REST, time_from_start=1.0)), 0.0)
        robot.tick()
        return robot.hardware.command[1]

    velocity = 6 * DT * (1 - DT)  # of the cubic from rest to rest within a second
    assert command(7.0) - command(0.0) == pytest.approx(7.0 * velocity)


def test_it_starts_by_holding_the_measured_position() -> None:
    robot, _controller = arm()
    robot.position[1] = 0.3
    robot.manager.restart(robot.state)
    robot.run(0.01)
    assert robot.position[1] == 0.3


def test_success_needs_all_joints_within_tolerance_at_once() -> None:
    robot, controller = arm({"constraints.goal_time": 5.0})
    far = {"goal_tolerance": dict.fromkeys(NAMES, Tolerance(position=0.01))}
    free = {"path_tolerance": dict.fromkeys(NAMES, -1.0)}
    handle = controller.follow(
        goal(Point([0.5, 0.5, 0.5], REST, time_from_start=0.5), **far, **free), 0.0
    )
    robot.blocked = {"slide"}
    robot.run(0.6)  # the hip is there
    robot.blocked = {"hip", "slide"}
    robot.position[1], robot.position[2] = 0.4, 0.5
    robot.run(0.1)  # now the slide is, and the hip is not
    assert handle.status is GoalStatus.ACTIVE
    robot.blocked = set()
    robot.run(0.01)
    assert handle.result == REACHED


def test_a_goal_time_of_zero_waits_for_ever() -> None:
    robot, controller = arm({"constraints.goal_time": 0.0})
    free = {"path_tolerance": dict.fromkeys(NAMES, -1.0)}
    robot.blocked = {"hip"}
    handle = controller.follow(
        goal(Point([0.5, 0, 0], REST, time_from_start=0.5), **free), 0.0
    )
    robot.run(20.0)
    assert handle.status is GoalStatus.ACTIVE
    robot.blocked = set()
    robot.run(0.01)
    assert handle.result == REACHED


def test_a_point_of_now_is_commanded_at_once_and_judged_on_the_path() -> None:
    robot, controller = arm()
    controller.follow(goal(Point([0.05, 0, 0])), 0.0)
    robot.tick()
    assert robot.position[1] == 0.05
    handle = controller.follow(goal(Point([0.5, 0, 0])), robot.time)
    robot.tick()
    assert handle.result.error_code == GoalResult.PATH_TOLERANCE_VIOLATED
    assert robot.position[1] == 0.05


# ---- starting ----------------------------------------------------------------------


def sagged(**parameters: object):
    """Return a robot whose hip is measured 0.05 below its setpoint, in motion."""
    robot, controller = arm(parameters, Interface.EFFORT)
    robot.run(0.01)
    robot.position[1], robot.velocity[1] = -0.05, 0.2
    return robot, controller


def test_a_goal_starts_from_the_motion_that_is_measured_in_its_first_tick() -> None:
    robot, controller = sagged()
    start = robot.time
    controller.follow(goal(Point([1, 0, 0], REST, time_from_start=1.0)), start)
    robot.tick()
    motion = controller.query_state(start)
    assert motion.positions[0] == -0.05
    assert motion.velocities[0] == 0.2


def test_or_from_the_desired_motion_where_a_parameter_says_so() -> None:
    for parameter in ("interpolate_from_desired_state", "open_loop_control"):
        robot, controller = sagged(**{parameter: "true"})
        start = robot.time
        controller.follow(goal(Point([1, 0, 0], REST, time_from_start=1.0)), start)
        robot.tick()
        assert desired(controller, start)[0] == 0.0


def test_missing_states_at_the_start_count_as_zero() -> None:
    robot, controller = arm({"state_interfaces": "[position]"})
    robot.velocity[1] = 0.7
    point = Point([1, 0, 0], REST, [2.0, 0.0, 0.0], time_from_start=1.0)
    controller.follow(goal(point), 0.0)
    robot.tick()
    start, end = controller.query_state(0.0), controller.query_state(1.0)
    assert (start.velocities[0], start.accelerations[0]) == (0.0, 0.0)
    assert end.accelerations[0] == pytest.approx(2.0)  # a quintic: with accelerations


def test_points_in_the_past_are_kept_and_sampling_starts_between_them() -> None:
    robot, controller = arm()
    robot.run(1.0)
    controller.command(
        goal(
            Point([0.0, 0, 0], time_from_start=0.2),
            Point([0.1, 0, 0], time_from_start=1.2),
            stamp=0.3,
        ),
        robot.time,
    )
    robot.tick()
    assert robot.position[1] == pytest.approx(0.05 + 0.1 * DT)  # half of the way, now
    robot.run(0.6)
    assert robot.position[1] == 0.1


def test_positions_alone_are_linear_and_velocities_make_cubics() -> None:
    for velocities, quarter in ((None, 0.25), (REST, 0.15625)):
        robot, controller = arm()
        controller.follow(goal(Point([1, 0, 0], velocities, time_from_start=1.0)), 0.0)
        robot.run(0.1)
        assert desired(controller, 0.25)[0] == pytest.approx(quarter)


def test_without_interpolation_each_point_is_sent_as_it_is() -> None:
    robot, controller = arm({"interpolation_method": "none"})
    points = [Point([0.1 * k, 0, 0], time_from_start=0.1 * k) for k in (1, 2, 3)]
    controller.command(goal(*points), 0.0)
    seen = []
    for _ in range(400):
        robot.tick()
        if not seen or robot.position[1] != seen[-1][1]:
            seen.append((round(robot.time, 3), robot.position[1]))
    wanted = [(0.001, 0.0), (0.1, 0.2), (0.2, 0.3)]
    assert seen == [(time, pytest.approx(q)) for time, q in wanted]


def test_velocities_alone_are_integrated_where_a_parameter_allows_it() -> None:
    robot, controller = arm({"allow_integration_in_goal_trajectories": "true"})
    robot.run(0.01)
    controller.follow(
        goal(
            Point([], [0.2, 0, 0], time_from_start=1.0),
            Point([], [0.0, 0, 0], time_from_start=2.0),
        ),
        robot.time,
    )
    robot.run(2.0)
    assert robot.position[1] == pytest.approx(0.2)
    controller.follow(
        goal(
            Point([], None, [0.2, 0, 0], time_from_start=1.0),
            Point([], None, [-0.4, 0, 0], time_from_start=2.0),
        ),
        robot.time,
    )
    robot.run(2.0)
    assert robot.position[1] == pytest.approx(0.2 + 0.05 + 0.05, abs=1e-3)


def test_a_continuous_joint_goes_the_shortest_way_round() -> None:
    robot, controller = arm()
    handle = controller.follow(goal(Point([0, 0, 6.2], REST, time_from_start=1.0)), 0.0)
    robot.run(1.1)
    assert robot.position[3] == pytest.approx(6.2 - 2 * 3.141592653589793)
    assert handle.result == REACHED


def test_positions_of_the_topic_become_a_smooth_spline() -> None:
    changes = {
        "positions_upsampling.enable": "true",
        "positions_upsampling.policy_frequency": 5.0,
    }
    robot, controller = arm(changes)
    points = [Point([q, 0, 0]) for q in (0.1, 0.4, 0.3, 0.6)]  # without times
    controller.command(goal(*points), 0.0)
    robot.run(0.1)
    for k, q in enumerate((0.1, 0.4, 0.3, 0.6)):
        assert desired(controller, 0.2 * (k + 1))[0] == pytest.approx(q)
    for time in (0.4, 0.6):  # accelerations are continuous at inner points
        before, after = (
            controller.query_state(time + dt).accelerations[0] for dt in (-1e-9, 1e-9)
        )
        assert before == pytest.approx(after, abs=1e-5)
    assert controller.query_state(0.2).velocities[0] == 0.0
    assert controller.query_state(0.8).velocities[0] == pytest.approx(0.0)


# ---- tolerances --------------------------------------------------------------------


def violated(**options: object):
    robot, controller = arm()
    robot.blocked = {"hip"}
    point = Point([0.5, 0.5, 0.5], REST, time_from_start=0.5)
    handle = controller.follow(goal(point, **options), 0.0)
    return robot, controller, handle


def test_a_violated_path_aborts_and_holds_the_measured_position(caplog) -> None:
    robot, _, handle = violated()
    with caplog.at_level(logging.WARNING):
        robot.run(0.3)
    result = handle.result
    assert (result.status, result.error_code) == (GoalStatus.ABORTED, -4)
    assert result.error_string.startswith(
        "Aborted due to path tolerance violation; hip is off by 0.1"
    )
    assert "hip 0.1" in caplog.text
    slide = robot.position[2]
    assert 0.05 < slide < 0.2
    robot.run(1.0)
    assert robot.position[2] == slide


def test_a_missed_goal_aborts_after_the_goal_time_and_says_by_how_much() -> None:
    robot, _, handle = violated(path_tolerance=dict.fromkeys(NAMES, -1.0))
    robot.run(1.0)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.01)
    assert handle.result.error_code == -5
    assert handle.result.error_string == (
        "Aborted due to goal_time_tolerance exceeding by 0.501000 seconds; "
        "hip is off by 0.500000"
    )


@pytest.mark.parametrize(
    ("options", "log", "code", "when"),
    [
        ({}, "", -4, 0.2),
        ({"path_tolerance": {"hip": 0.0}}, "", -4, 0.2),
        ({"path_tolerance": {"hip": -1.0}}, "", -5, 1.0),
        ({"path_tolerance": {"hip": 0.4}}, "", -4, 0.4),
        ({"path_tolerance": {"hip": -0.5}}, "invalid tolerance -0.5", -4, 0.2),
        (
            {"path_tolerance": {"hip": -1.0, "hop": 0.4}},
            "joint 'hop' specified in goal.path_tolerance does not exist",
            -4,
            0.2,
        ),
        (
            {"path_tolerance": {"hip": -1.0}, "goal_time_tolerance": -0.5},
            "illegal goal_time_tolerance: -0.5",
            -4,
            0.2,
        ),
        ({"path_tolerance": {"hip": -1}, "goal_time_tolerance": 0.2}, "", -5, 0.7),
        ({"path_tolerance": {"hip": -1}, "goal_time_tolerance": -1.0}, "", None, 9.0),
        ({"path_tolerance": {"hip": -1}, "goal_tolerance": {"hip": -1}}, "", 0, 0.5),
    ],
)
def test_the_tolerances_of_a_goal(caplog, options, log, code, when) -> None:
    robot, _, handle = violated(**options)
    assert log in caplog.text
    assert bool(log) == ("Using default tolerances" in caplog.text)
    robot.run(when - 0.1)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.2)
    assert (handle.result and handle.result.error_code) == code


@pytest.mark.parametrize(
    ("interface", "commanded", "status"),
    [
        (Interface.POSITION, "[position]", GoalStatus.SUCCEEDED),
        (Interface.POSITION, "[position, velocity]", GoalStatus.ACTIVE),
        (Interface.VELOCITY, "[velocity]", GoalStatus.ACTIVE),
        (Interface.EFFORT, "[effort]", GoalStatus.ACTIVE),
    ],
)
def test_velocities_are_judged_only_if_they_or_efforts_are_commanded(
    interface: Interface, commanded: str, status: GoalStatus
) -> None:
    robot, controller = arm({"command_interfaces": commanded}, interface)
    point = Point([0, 0, 0], REST, time_from_start=0.5)
    handle = controller.follow(goal(point), 0.0)
    for _ in range(505):
        robot.velocity[1] = 0.06  # the stopped velocity tolerance is 0.05
        robot.manager.update(robot.state, DT)
        robot.ticks += 1
    assert handle.status is status


def test_a_trajectory_of_the_topic_is_judged_too(caplog) -> None:
    robot, controller = arm()
    robot.blocked = {"hip"}
    controller.command(goal(Point([0.5, 0.5, 0.5], REST, time_from_start=0.5)), 0.0)
    robot.run(1.0)
    assert 0.05 < robot.position[2] < 0.2
    assert "Holding position; position errors: hip 0.1" in caplog.text


# ---- replacing ---------------------------------------------------------------------


def moving(changes: dict[str, str]):
    """Return a robot that has moved for half a second of two."""
    robot, controller = arm(changes)
    points = [Point([0.5 * k] * 3, time_from_start=float(k)) for k in (1, 2)]
    handle = controller.follow(goal(*points), 0.0)
    robot.run(0.5)
    return robot, controller, handle


def test_a_new_goal_aborts_the_old_one() -> None:
    robot, controller, old = moving({})
    new = controller.follow(goal(Point(REST, REST, time_from_start=1.0)), robot.time)
    assert old.result == REPLACED
    robot.run(1.1)
    assert new.result == REACHED


def test_a_message_keeps_the_goal_which_is_judged_by_the_new_points() -> None:
    robot, controller, handle = moving({})
    controller.command(goal(Point(REST, REST, time_from_start=1.0)), robot.time)
    robot.run(0.99)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.02)
    assert handle.result == REACHED
    assert robot.position[1:] == REST


def test_a_trajectory_of_the_future_is_spliced() -> None:
    robot, controller, _ = moving({})
    point = Point(REST, REST, time_from_start=1.0)
    new = controller.follow(goal(point, stamp=1.5), robot.time)
    robot.run(1.0)
    assert robot.position[1] == pytest.approx(0.75)  # the old one went on until then
    robot.run(1.05)
    assert robot.position[1:] == REST
    assert new.result == REACHED


def test_or_it_replaces_at_once_and_the_joints_glide_to_its_first_point() -> None:
    robot, controller, _ = moving(AT_ONCE)
    point = Point([0.25] * 3, REST, time_from_start=1.0)
    controller.follow(goal(point, stamp=1.5), robot.time)
    positions = []
    for _ in range(2000):
        robot.tick()
        positions.append(robot.position[1])
    assert max(positions) < 0.5  # it does not go on to 0.75
    assert positions[-1] == 0.25
    assert abs(positions[1000] - 0.25) > 0.01  # it takes its time until then


def test_a_message_of_one_point_is_replaced_at_once_as_in_ros() -> None:
    robot, controller = arm()
    controller.command(goal(Point([1.0] * 3, time_from_start=2.0)), 0.0)
    robot.run(0.5)
    controller.command(
        goal(Point([0.0] * 3, time_from_start=1.0), stamp=1.0), robot.time
    )
    robot.run(0.5)
    assert robot.position[1] < 0.25


def test_joints_that_a_partial_goal_leaves_out_go_on() -> None:
    robot, controller, _ = moving(PARTIAL)
    alone = goal(Point([0.0], time_from_start=0.5), joint_names=["slide"])
    handle = controller.follow(alone, robot.time)
    robot.run(0.6)
    assert robot.position[2] == 0.0
    assert robot.position[1] == pytest.approx(0.55)
    assert handle.status is GoalStatus.ACTIVE  # until the others have arrived, too
    robot.run(1.0)
    assert robot.position[1:] == [1.0, 0.0, 1.0]
    assert handle.result == REACHED


def test_or_they_hold_where_they_are() -> None:
    robot, controller, _ = moving({**PARTIAL, **AT_ONCE})
    alone = goal(Point([0.0], time_from_start=0.5), joint_names=["slide"])
    handle = controller.follow(alone, robot.time)
    robot.run(0.6)
    assert robot.position[1:] == pytest.approx([0.25, 0.0, 0.25])
    assert handle.result == REACHED


def test_a_plan_starts_with_the_desired_motion() -> None:
    robot, controller, old = moving(AT_ONCE)
    plan = [[(0.5, Motion(0.3, 0.0, 0.0))]] * 3
    handle = controller.follow(plan, robot.time)
    assert old.result == REPLACED
    before = robot.position[1]
    robot.tick()
    assert robot.velocity[1] == pytest.approx(0.5, rel=0.01)  # it has been that
    assert robot.position[1] == pytest.approx(before + 0.5 * DT, abs=1e-6)
    robot.run(0.6)
    assert handle.result == REACHED


@pytest.mark.parametrize("has_points", [True, False])
def test_motions_that_the_kernel_started(has_points: bool) -> None:
    """They are judged as trajectories of the topic; another one may follow them."""
    robot, controller, _ = moving({})
    controller.stop()
    q, end = robot.position[1], robot.time + 0.5
    rising = Segment.of(robot.time, end, (q, 0.5, 0.0, 0.0, 0.0, 0.0))
    splines = dict.fromkeys(range(3), along(rising))
    controller.resume_from_kernel(
        splines, robot.time, is_first=True, has_points=has_points
    )
    robot.run(0.25)
    assert robot.velocity[1] == pytest.approx(0.5, rel=0.01)
    last = [robot.position[1]] * 3
    controller.command(goal(Point(last, REST, time_from_start=1.0)), robot.time)
    law = controller.law()
    assert law is None  # the next tick starts it
    robot.tick()
    law = controller.law()
    assert law is not None
    assert law.has_points == has_points


# ---- stopping ----------------------------------------------------------------------


def test_a_cancelled_goal_holds_the_measured_position() -> None:
    robot, controller, handle = moving({})
    place = robot.position[1] - 0.5 * DT  # as of the last update
    controller.cancel(handle, robot.time)
    assert handle.result == GoalResult(status=GoalStatus.PREEMPTED)
    robot.run(0.5)
    assert robot.position[1] == pytest.approx(place)


def test_a_goal_that_is_not_active_cannot_be_cancelled() -> None:
    robot, controller, old = moving({})
    new = controller.follow(goal(Point(REST, time_from_start=1.0)), robot.time)
    controller.cancel(old, robot.time)
    assert new.status is GoalStatus.ACTIVE


def test_a_cancelled_goal_slows_down_where_every_joint_has_a_deceleration() -> None:
    changes = {"constraints.decelerate_on_cancel": "true"}
    changes |= {f"constraints.{n}.max_deceleration_on_cancel": "2.0" for n in NAMES}
    robot, controller, handle = moving(changes)
    place = robot.position[1] - 0.5 * DT
    controller.cancel(handle, robot.time)
    robot.run(0.1)
    assert robot.velocity[1] == pytest.approx(0.3, abs=0.01)
    robot.run(0.5)
    assert robot.position[1] == pytest.approx(place + 0.5**2 / (2 * 2.0))
    assert robot.velocity[1] == 0.0


def test_otherwise_it_holds_which_is_logged(caplog) -> None:
    changes = {"constraints.decelerate_on_cancel": "true"}
    robot, controller, handle = moving(changes)
    assert "Joint [hip] has invalid max_deceleration_on_cancel [0.0]" in caplog.text
    controller.cancel(handle, robot.time)
    robot.run(0.1)
    assert robot.velocity[1] == 0.0


def test_a_deactivated_controller_aborts_its_goal() -> None:
    _robot, controller, handle = moving({})
    controller.stop()
    assert handle.result == GoalResult(
        status=GoalStatus.ABORTED,
        error_code=-1,
        error_string="Current goal cancelled during deactivate transition.",
    )


def test_a_command_times_out_some_time_after_its_end() -> None:
    robot, controller = arm({"cmd_timeout": 1.0})
    robot.blocked = {"hip"}
    free = {"path_tolerance": dict.fromkeys(NAMES, -1.0), "goal_time_tolerance": -1.0}
    point = Point([0.5] * 3, REST, time_from_start=0.5)
    handle = controller.follow(goal(point, **free), 0.0)
    robot.run(1.5)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.01)
    assert handle.result.error_string == (
        "Aborted due to command timeout; hip is off by 0.500000"
    )
    assert desired(controller, robot.time)[0] == 0.0


def test_a_command_timeout_within_the_goal_time_is_ignored(caplog) -> None:
    _, controller = arm({"cmd_timeout": 0.5})
    assert "must be higher than goal_time tolerance" in caplog.text
    assert controller.spec.command_timeout == float("inf")


# ---- the speed ---------------------------------------------------------------------


def test_trajectory_time_advances_by_the_factor_of_the_speed() -> None:
    robot, controller = arm()
    handle = controller.follow(goal(Point([0.5] * 3, time_from_start=1.0)), 0.0)
    robot.run(0.5)
    controller.scale_speed(0.5)
    robot.run(0.5)
    assert robot.position[1] == pytest.approx(0.375, abs=0.002)
    state = controller.setpoint().state()
    assert state.speed_scaling == 0.5
    assert state.error.positions == pytest.approx(REST, abs=0.001)
    controller.scale_speed(0.0)
    place = robot.position[1]
    robot.run(5.0)
    assert robot.position[1] == pytest.approx(place, abs=0.001)
    assert handle.status is GoalStatus.ACTIVE
    controller.scale_speed(1.0)
    robot.run(0.27)
    assert handle.result == REACHED


def test_while_it_is_slow_replacement_and_queries_count_trajectory_time() -> None:
    robot, controller, _ = moving({})
    controller.scale_speed(0.5)
    robot.run(0.5)
    assert desired(controller, robot.time)[0] == pytest.approx(0.375, abs=0.002)
    point = Point(REST, REST, time_from_start=1.0)
    new = controller.follow(goal(point, stamp=robot.time + 0.2), robot.time)
    robot.run(0.2)
    assert robot.position[1] == pytest.approx(0.425, abs=0.002)
    robot.run(2.1)
    assert new.result == REACHED


def test_while_it_is_paused_goals_and_queries_still_work() -> None:
    robot, controller, _ = moving({})
    controller.scale_speed(0.0)
    for k in range(50):
        robot.run(0.01 + 0.001 * k)
        place = desired(controller, robot.time)
        handle = controller.follow(
            goal(Point(REST, REST, time_from_start=1.0)), robot.time
        )
        assert desired(controller, robot.time) == pytest.approx(place, abs=1e-9)
    controller.scale_speed(1.0)
    robot.run(1.1)
    assert handle.result == REACHED


def test_the_speed_slider_scales_it_where_the_state_interface_is_named() -> None:
    interface = {"speed_scaling.state_interface": "speed_scaling/speed_scaling_factor"}
    robot, controller = arm(interface)
    assert (
        "speed_scaling/speed_scaling_factor"
        in robot.manager.status("arm").state_interfaces
    )
    controller.follow(goal(Point([0.5] * 3, time_from_start=1.0)), 0.0)
    robot.hardware.speed_scaling[""] = 0.5
    robot.run(1.0)
    assert robot.position[1] == pytest.approx(0.25, abs=0.002)
    with pytest.raises(ControlError, match="speed slider"):
        controller.scale_speed(0.7)


def test_the_scaled_controller_follows_the_slider_by_itself() -> None:
    robot, controller = arm({"type": "ur_controllers/ScaledJointTrajectoryController"})
    robot.hardware.speed_scaling[""] = 0.25
    controller.follow(goal(Point([0.5] * 3, time_from_start=1.0)), 0.0)
    robot.run(1.0)
    assert robot.position[1] == pytest.approx(0.125, abs=0.002)


def test_the_initial_factor_is_a_parameter() -> None:
    _, controller = arm({"speed_scaling.initial_scaling_factor": 0.5})
    assert controller.speed_scaling == 0.5


@pytest.mark.parametrize("factor", [-0.1, float("nan"), float("inf")])
def test_an_impossible_factor_is_ignored(factor: float) -> None:
    _, controller = arm()
    with pytest.raises(ControlError, match="greater or equal to 0"):
        controller.scale_speed(factor)
    assert controller.speed_scaling == 1.0


def test_only_pure_position_controllers_can_be_scaled() -> None:
    _, controller = arm(interface=Interface.EFFORT)
    with pytest.raises(ControlError, match="nothing but positions"):
        controller.scale_speed(0.5)
