import logging
import math

import pytest
from toy_robot import ARM, DT, JOINTS, POSITION_ARM, ToyRobot

from tool0.control.tolerances import DEFAULT_GOAL_TIME
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Interface
from tool0.errors import GoalRejectedError
from tool0.protocol.goals import GoalResult, GoalStatus, Tolerance
from tool0.protocol.trajectories import TrajectoryPoint

Point = TrajectoryPoint
REST = [0.0, 0.0, 0.0]


def goal(*points: Point, **options) -> TrajectoryGoal:
    return TrajectoryGoal(points=list(points), **options)


def arm(yaml: str = ARM, interface: Interface = Interface.EFFORT):
    robot = ToyRobot(yaml, interface)
    return robot, robot.start("arm")


def position_arm():
    return arm(POSITION_ARM, Interface.POSITION)


def desired(controller, time: float):
    return controller.query_state(time).positions


# ---- following ---------------------------------------------------------------------


@pytest.mark.parametrize(
    "interface", [Interface.EFFORT, Interface.POSITION, Interface.VELOCITY]
)
def test_follows_a_trajectory_on_every_interface(interface: Interface) -> None:
    package = interface.name.lower()
    yaml = ARM.replace("effort_controllers", f"{package}_controllers")
    if interface is Interface.VELOCITY:
        yaml = yaml.replace("p: 4000, d: 126", "p: 20, d: 0")
        yaml += "  velocity_ff: {hip: 1, slide: 1, wheel: 1}"
    robot, controller = arm(yaml, interface)
    handle = controller.follow(
        goal(
            Point([0.5, -0.2, 1.0], [0.5, 0.0, 1.0], time_from_start=1.0),
            Point([1.0, -0.4, 2.0], REST, time_from_start=2.0),
        ),
        robot.time,
    )
    for _ in range(1999):
        robot.tick()
        assert handle.status is GoalStatus.ACTIVE
    robot.run(0.1)
    assert handle.result == GoalResult(status=GoalStatus.SUCCEEDED)
    assert robot.position[1:] == pytest.approx([1.0, -0.4, 2.0], abs=0.01)


def test_a_goal_starts_with_the_coming_tick_and_ends_on_time() -> None:
    robot, controller = position_arm()
    robot.run(0.25)
    handle = controller.follow(goal(Point([1, 2, 3], time_from_start=0.5)), robot.time)
    robot.tick()
    assert robot.position[1:] == REST
    robot.tick()
    assert robot.position[1:] == pytest.approx([0.002, 0.004, 0.006])
    robot.run(0.498)
    assert handle.status is GoalStatus.ACTIVE
    robot.tick()
    assert robot.position[1:] == [1.0, 2.0, 3.0]
    assert handle.status is GoalStatus.SUCCEEDED


def test_state_and_query_agree() -> None:
    robot, controller = arm()
    controller.follow(goal(Point([1, 1, 1], REST, time_from_start=1.0)), 0.0)
    robot.run(0.4)
    state = controller.setpoint().state()
    query = controller.query_state(state.time)
    assert state.joint_names == ("hip", "slide", "wheel")
    assert state.desired.positions == query.positions
    assert state.desired.velocities == query.velocities
    assert state.desired.accelerations == query.accelerations
    assert state.actual.time_from_start == pytest.approx(0.399)
    for wanted, actual, error in zip(
        state.desired.positions,
        state.actual.positions,
        state.error.positions,
        strict=True,
    ):
        assert error == pytest.approx(wanted - actual)


def test_velocity_feed_forward_scales_the_desired_velocity() -> None:
    yaml = ARM + "  velocity_ff: {hip: 7.0}\n"
    robot, controller = arm(yaml)
    plain_robot, plain = arm()
    for r, c in ((robot, controller), (plain_robot, plain)):
        c.follow(goal(Point([1, 1, 1], time_from_start=2.0)), 0.0)
        r.tick()
    difference = [
        a - b
        for a, b in zip(
            robot.hardware.command, plain_robot.hardware.command, strict=True
        )
    ]
    assert difference[1:] == pytest.approx([3.5, 0.0, 0.0])


# ---- replacing ---------------------------------------------------------------------


def test_while_old_segments_run_the_new_goals_tolerances_wait() -> None:
    robot, controller = arm()
    robot.blocked = {"hip"}
    controller.command(goal(Point([1, 0, 0], time_from_start=1.0)), 0.0)
    late = goal(Point([0, 0, 0], time_from_start=2.0), stamp=0.8)
    handle = controller.follow(late, 0.0)
    robot.run(0.7)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.2)
    assert handle.result.error_code == GoalResult.PATH_TOLERANCE_VIOLATED


def test_points_in_the_past_are_dropped_and_the_rest_runs(caplog) -> None:
    robot, controller = position_arm()
    robot.run(0.5)
    with caplog.at_level(logging.WARNING):
        handle = controller.follow(
            goal(
                Point([5, 5, 5], time_from_start=0.1),
                Point([1, 1, 1], time_from_start=1.0),
                stamp=0.2,
            ),
            robot.time,
        )
    assert "Dropping first 1 trajectory point(s) out of 2" in caplog.text
    robot.run(0.71)
    assert robot.position[1:] == [1.0, 1.0, 1.0]
    assert handle.status is GoalStatus.SUCCEEDED


@pytest.mark.parametrize("stamp", [None, 0.5])
def test_a_point_at_the_start_is_dropped_without_a_word(caplog, stamp) -> None:
    robot, controller = position_arm()
    first = Point([1, 1, 1], time_from_start=0.0)
    last = Point([2, 2, 2], time_from_start=1.0)
    controller.follow(goal(first, last, stamp=stamp), 0.0)
    start = stamp or 0.0
    assert desired(controller, start) == (0.0, 0.0, 0.0)
    assert desired(controller, start + 0.5) == pytest.approx((1.0, 1.0, 1.0))
    robot.run(start + 1.001)
    assert robot.position[1:] == [2.0, 2.0, 2.0]
    assert not caplog.text


# ---- stopping ----------------------------------------------------------------------


def test_without_a_ramp_a_cancel_holds_the_measured_position() -> None:
    yaml = ARM.replace("stop_trajectory_duration: 0.5", "")
    robot, controller = arm(yaml)
    handle = controller.follow(goal(Point([2, 2, 2], time_from_start=2.0)), 0.0)
    robot.run(1.0)
    robot.tick()
    measured = controller.setpoint().state().actual.positions
    controller.cancel(handle, robot.time)
    assert desired(controller, robot.time) == measured


def test_cancelling_another_goal_changes_nothing() -> None:
    _, controller = arm()
    old = controller.follow(goal(Point([2, 2, 2], time_from_start=2.0)), 0.0)
    new = controller.follow(goal(Point([1, 1, 1], time_from_start=2.0)), 0.0)
    controller.cancel(old, 0.0)
    assert new.status is GoalStatus.ACTIVE
    assert desired(controller, 2.0) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("by_action", [True, False])
def test_an_empty_message_cancels_what_came_by_either_way(by_action: bool) -> None:
    robot, controller = arm()
    message = goal(Point([2, 2, 2], time_from_start=2.0))
    handle = controller.follow(message, 0.0) if by_action else None
    if not by_action:
        controller.command(message, 0.0)
    robot.run(0.5)
    controller.command(goal(), robot.time)
    assert handle is None or handle.status is GoalStatus.PREEMPTED
    robot.run(1.0)
    assert robot.position[1] == pytest.approx(0.5 + 0.625 * 0.5, abs=1e-3)


# ---- tolerances --------------------------------------------------------------------


def test_a_goals_own_tolerances_replace_switch_off_or_keep() -> None:
    robot, controller = arm()
    robot.blocked = {"hip"}

    def outcome(**options) -> int:
        handle = controller.follow(
            goal(Point([0.2, 0, 0], time_from_start=0.2), **options), robot.time
        )
        robot.run(1.5)
        return handle.result.error_code

    slow = {"hip": Tolerance(position=-1.0, velocity=0.2)}
    assert outcome(path_tolerance=slow) == -4
    assert outcome() == -4
    assert outcome(path_tolerance={"hip": 0.0}) == -4
    assert outcome(path_tolerance={"hip": -1.0}) == -5
    assert outcome(path_tolerance={"hip": 0.3}, goal_tolerance={"hip": 0.3}) == 0
    loose = {"hip": Tolerance(position=-1.0)}
    assert outcome(path_tolerance=loose, goal_tolerance=loose) == 0


@pytest.mark.parametrize(
    ("goal_time", "own", "grace"),
    [
        ("goal_time: 0.5", 2.0, 2.0),
        ("goal_time: 0.5", 0.0, 0.5),
        ("goal_time: 0.5", -1.0, math.inf),
        ("goal_time: 0", 0.0, 0.0),
        ("", 0.0, DEFAULT_GOAL_TIME),
    ],
)
def test_the_grace_is_that_of_the_goal_else_of_the_yaml_else_ours(
    goal_time: str, own: float, grace: float
) -> None:
    robot, controller = arm(ARM.replace("goal_time: 0.5", goal_time))
    robot.blocked = {"hip"}
    late = goal(Point([0.05, 0, 0], time_from_start=0.1), goal_time_tolerance=own)
    handle = controller.follow(late, 0.0)
    robot.run(0.1 + min(grace, 5.0))
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.002)
    assert (handle.status is GoalStatus.ABORTED) == (grace < math.inf)


def test_a_joint_counts_as_arrived_once_it_was() -> None:
    robot, controller = arm()
    robot.blocked = {"slide"}
    handle = controller.follow(
        goal(
            Point([0.05, 0.05, 0], REST, time_from_start=0.1), goal_time_tolerance=2.0
        ),
        0.0,
    )
    robot.run(0.5)
    robot.blocked = {"hip"}
    robot.position[1] = 1.0
    robot.run(1.0)
    assert handle.status is GoalStatus.SUCCEEDED


# ---- partial goals -----------------------------------------------------------------


def test_a_partial_goal_leaves_the_other_joints_alone() -> None:
    robot, controller = position_arm()
    controller.follow(goal(Point([1, 1, 1], time_from_start=1.0)), 0.0)
    robot.run(0.5)
    partial = goal(Point([0.0], time_from_start=1.0), joint_names=["slide"])
    handle = controller.follow(partial, robot.time)
    robot.run(0.501)
    assert robot.position[1:] == pytest.approx([1.0, 0.25, 1.0])
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.5)
    assert handle.status is GoalStatus.SUCCEEDED


def test_a_partial_goal_succeeds_only_when_the_other_joints_arrived_as_well() -> None:
    robot, controller = position_arm()
    controller.follow(goal(Point([1, 1, 1], time_from_start=1.0)), 0.0)
    partial = goal(Point([0.5], time_from_start=0.2), joint_names=["slide"])
    handle = controller.follow(partial, 0.0)
    robot.run(0.5)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(0.51)
    assert handle.status is GoalStatus.SUCCEEDED


# ---- angles ------------------------------------------------------------------------


def test_a_continuous_joint_begins_the_shortest_way_and_keeps_its_turns() -> None:
    robot, controller = position_arm()
    first = Point([5.0, 5.0, 5.0], time_from_start=0.5)
    last = Point([5.0, 5.0, 15.0], time_from_start=1.0)
    controller.follow(goal(first, last), 0.0)
    robot.run(0.501)
    assert robot.position[1:] == pytest.approx([5.0, 5.0, 5.0 - math.tau])
    robot.run(0.6)
    assert robot.position[1:] == pytest.approx([5.0, 5.0, 15.0 - math.tau])


def test_the_error_of_a_joint_with_limits_is_not_wrapped() -> None:
    robot, controller = arm(ARM.replace("trajectory: 0.1", "trajectory: 0"))
    robot.blocked = {"hip", "wheel"}
    controller.command(goal(Point([4.0, 0, 4.0], time_from_start=0.1)), 0.0)
    robot.run(0.2)
    errors = controller.setpoint().state().error.positions
    assert errors[0] == pytest.approx(4.0)
    assert errors[2] == pytest.approx(4.0 - math.tau)
    assert robot.hardware.command[1] > 0.0 > robot.hardware.command[3]


# ---- rejections --------------------------------------------------------------------

NAMES = ["hip", "slide", "wheel"]
ONE = Point([1, 1, 1], time_from_start=1.0)
NAN = math.nan
BAD_JOINTS = {
    "unknown joint": (goal(ONE, joint_names=["hip", "slid", "wheel"]), "'slide'"),
    "missing joint": (goal(ONE, joint_names=NAMES[:2]), "wheel"),
    "extra joint": (goal(ONE, joint_names=[*NAMES, "idle"]), "'idle'"),
    "no joint": (goal(ONE, joint_names=[]), "hip, slide, wheel"),
    "joint twice": (goal(ONE, joint_names=["hip", "hip", "wheel"]), "'hip'"),
    "tolerance of nobody": (goal(ONE, path_tolerance={"hop": 1.0}), "'hip'"),
}
"""And a name or value that the message shows."""
BAD_POINTS = {
    "times equal": (goal(ONE, ONE), "1.0 s"),
    "time NaN": (goal(Point([1, 1, 1], time_from_start=NAN)), "nan"),
    "time zero": (goal(Point([1, 1, 1])), "0.000s"),
    "time negative": (goal(Point([1, 1, 1], time_from_start=-1.0)), "1.000s"),
    "all in the past": (goal(ONE, stamp=-3.0), "2.500s"),
    "start of a future goal": (goal(Point([1, 1, 1]), stamp=0.6), "0.000s"),
    "stamp NaN": (goal(ONE, stamp=NAN), "nan"),
    "no positions": (goal(Point([], time_from_start=1)), "0 positions"),
    "few positions": (goal(Point([1, 1], time_from_start=1)), "2 positions"),
    "many positions": (goal(Point([1] * 4, time_from_start=1)), "4 positions"),
    "few velocities": (goal(Point(REST, [0], time_from_start=1)), "1 velocities"),
    "many accelerations": (
        goal(Point(REST, REST, [0] * 4, time_from_start=1)),
        "4 accelerations",
    ),
    "NaN position": (goal(Point([1, NAN, 1], time_from_start=1)), "'slide'"),
    "inf velocity": (goal(Point(REST, [0, 0, math.inf], time_from_start=1)), "'wheel'"),
    "NaN acceleration": (
        goal(Point(REST, REST, [NAN, 0, 0], time_from_start=1)),
        "'hip'",
    ),
    "huge velocity": (goal(Point(REST, [1e300, 0, 0], time_from_start=1)), "1e+300"),
    "above the limit": (goal(Point([6.1, 0, 0], time_from_start=1)), "[-6, 6]"),
    "below the limit": (goal(Point([0, -6.1, 0], time_from_start=1)), "'slide'"),
    "tolerance NaN": (goal(ONE, goal_tolerance={"hip": NAN}), "nan"),
    "grace NaN": (goal(ONE, goal_time_tolerance=NAN), "nan"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", [*BAD_JOINTS, *BAD_POINTS])
@pytest.mark.parametrize("method", ["follow", "command"])
def test_a_bad_goal_is_rejected_and_what_runs_is_untouched(
    case: str, method: str
) -> None:
    bad, shown = (BAD_JOINTS | BAD_POINTS)[case]
    robot, controller = arm()
    running = controller.follow(goal(Point([1, 1, 1], REST, time_from_start=1)), 0.0)
    robot.run(0.5)
    before = [controller.query_state(0.5 + 0.1 * k) for k in range(10)]
    with pytest.raises(GoalRejectedError) as error:
        getattr(controller, method)(bad, robot.time)
    assert error.value.code == (-2 if case in BAD_JOINTS else -1)
    assert shown in str(error.value)
    assert before == [controller.query_state(0.5 + 0.1 * k) for k in range(10)]
    robot.run(0.6)
    assert running.status is GoalStatus.SUCCEEDED


@pytest.mark.parametrize(
    "point",
    [
        Point([6.0 + 5e-7, 0, 0], time_from_start=1),  # a limit rounded in print
        Point([0, 0, 99.0], time_from_start=1),  # a continuous joint has none
        Point(REST, [2.0 * JOINTS["hip"].limits.velocity] * 3, time_from_start=1),
    ],
)
def test_limits_are_those_of_position_as_in_ros(point: Point) -> None:
    _, controller = position_arm()
    assert controller.follow(goal(point), 0.0).status is GoalStatus.ACTIVE


def test_positions_must_be_numbers() -> None:
    with pytest.raises(GoalRejectedError):
        Point(["far"], time_from_start=1.0)


def test_holds_what_it_measured_at_the_start() -> None:
    robot = ToyRobot(ARM)
    robot.position = [9.0, 0.1, 0.2, 0.3]
    controller = robot.start("arm")
    robot.run(0.1)
    assert desired(controller, 5.0) == (0.1, 0.2, 0.3)
    assert robot.position[1:] == pytest.approx([0.1, 0.2, 0.3], abs=1e-9)
    assert robot.time == pytest.approx(100 * DT)
