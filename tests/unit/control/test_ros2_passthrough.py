"""PassthroughTrajectoryController of UR's driver, over the toy robot."""

from __future__ import annotations

import pytest
from ros2_arm import NAMES, Point, goal
from toy_robot import ToyRobot

from tool0.control.controller import TrajectoryFollower
from tool0.description.model import Interface
from tool0.errors import ConfigError, GoalRejectedError
from tool0.protocol.goals import GoalResult, GoalStatus

ENDS, STILL = [0.5] * 3, [0.0] * 3
YAML = """
arm:
  ros__parameters:
    type: ur_controllers/PassthroughTrajectoryController
    tf_prefix: ""
    joints: [hip, slide, wheel]
    state_interfaces: [position, velocity]
    speed_scaling_interface_name: speed_scaling/speed_scaling_factor
"""


def passthrough() -> tuple[ToyRobot, TrajectoryFollower]:
    robot = ToyRobot(YAML, Interface.POSITION)
    controller = robot.start("arm")
    assert isinstance(controller, TrajectoryFollower)
    return robot, controller


@pytest.mark.parametrize(
    ("point", "quarter"),
    [
        (Point(ENDS, time_from_start=1.0), 3 / 16 - 2 / 64),
        (Point(ENDS, velocities=STILL, time_from_start=1.0), 3 / 16 - 2 / 64),
        (
            Point(ENDS, velocities=STILL, accelerations=STILL, time_from_start=1.0),
            10 / 64 - 15 / 256 + 6 / 1024,
        ),
    ],
    ids=["positions", "cubic", "quintic"],
)
def test_the_numbers_of_the_points_choose_the_splines(
    point: Point, quarter: float
) -> None:
    _, controller = passthrough()
    controller.follow(goal(point), 0.0)
    middle = controller.query_state(0.25)
    assert middle.positions == pytest.approx([0.5 * quarter] * 3)


def test_points_of_positions_are_each_reached_at_rest() -> None:
    _, controller = passthrough()
    ends = Point([1.0] * 3, time_from_start=2.0)
    controller.follow(goal(Point(ENDS, time_from_start=1.0), ends), 0.0)
    assert controller.query_state(1.0).velocities == pytest.approx(STILL)


def test_the_speed_slider_scales_it_and_the_result_has_the_scaled_time() -> None:
    robot, controller = passthrough()
    robot.hardware.speed_scaling[""] = 0.5
    handle = controller.follow(goal(Point(ENDS, time_from_start=1.0)), 0.0)
    robot.run(1.0)
    assert robot.position[1] == pytest.approx(0.25, abs=0.002)
    assert handle.status is GoalStatus.ACTIVE
    robot.run(1.1)
    assert handle.result == GoalResult(
        status=GoalStatus.SUCCEEDED,
        error_string="Trajectory executed successfully in 1.000000 (scaled) seconds! "
        "The real time needed for execution could be longer.",
    )


def test_a_cancel_slows_down_and_another_goal_may_follow() -> None:
    robot, controller = passthrough()
    first = controller.follow(goal(Point(ENDS, time_from_start=1.0)), 0.0)
    robot.run(0.5)
    with pytest.raises(GoalRejectedError, match="already executing"):
        controller.follow(goal(Point(STILL, time_from_start=1.0)), 0.5)
    controller.cancel(first, 0.5)
    assert first.status is GoalStatus.PREEMPTED
    speeds = controller.query_state(0.55).velocities
    assert all(0.3 < speed < 0.7 for speed in speeds)  # 0.75 - 4 · 0.05
    controller.follow(goal(Point(STILL, time_from_start=1.0)), 0.5)


@pytest.mark.parametrize(
    ("points", "options", "words"),
    [
        ([Point(ENDS[:2], time_from_start=1.0)], {}, "has: 2 positions"),
        (
            [
                Point(ENDS, time_from_start=1.0),
                Point(ENDS, velocities=STILL, time_from_start=2.0),
            ],
            {},
            "Point nr 2 has: 3 velocities",
        ),
        ([Point(ENDS, time_from_start=0.0)], {}, "from where 'hip' is"),
        ([], {}, "Empty trajectory"),
        (
            [Point(ENDS, time_from_start=1.0)],
            {"goal_tolerance": {"hip": 0.1}},
            "Tolerances for 1 joints given. This controller knows 3 joints",
        ),
        (
            [Point(ENDS, time_from_start=1.0)],
            {"goal_tolerance": dict.fromkeys(("knee", *NAMES[1:]), 0.1)},
            "'knee' given. This joint is not known",
        ),
        (
            [Point(ENDS, velocities=ENDS, time_from_start=1.0)],
            {},
            "Velocity of last trajectory point",
        ),
    ],
)
def test_goals_are_refused_with_the_reason(
    points: list[Point], options: dict[str, object], words: str
) -> None:
    _, controller = passthrough()
    with pytest.raises(GoalRejectedError, match=words):
        controller.follow(goal(*points, **options), 0.0)


def test_an_unknown_speed_interface_is_refused() -> None:
    yaml = YAML.replace("name: speed", "name: left_speed")
    robot = ToyRobot(yaml, Interface.POSITION)
    with pytest.raises(ConfigError, match="no state interface 'left_speed_scaling"):
        robot.start("arm")
