"""``StopMotions``, which also follows a standstill of the process."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import tool0
from tool0 import ControlConfig, DescriptionConfig, GoalStatus, TrajectoryPoint
from tool0.protocol.running import StopMotions

ELBOW = 2
FORWARDING = """\
speed: {type: effort_controllers/JointVelocityController, joint: wrist_3_joint,
  pid: {p: 20.0, i: 0.0, d: 0.0}}
position: {type: effort_controllers/JointPositionController, joint: elbow_joint,
  pid: {p: 500.0, i: 0.0, d: 50.0}}
"""


@pytest.fixture(params=[False, True], ids=["ros1", "ros2"])
def robot(request: pytest.FixtureRequest) -> Iterator[tool0.Robot]:
    description = DescriptionConfig(ros2_control=request.param)
    with tool0.bringup(realtime=False, description=description) as robot:
        yield robot


def joint(robot: tool0.Robot, name: str) -> tuple[float, float]:
    """Return position and velocity of a joint."""
    snapshot = robot.snapshot
    k = snapshot.joint_names.index(name)
    return snapshot.position[k], snapshot.velocity[k]


def stop(robot: tool0.Robot) -> None:
    robot.channel.call(StopMotions())


def require_rest(robot: tool0.Robot) -> None:
    """The robot comes to rest within a second, and stays there."""
    robot.run(1.0)
    before = robot.snapshot.position
    robot.run(1.0)
    assert robot.snapshot.position == pytest.approx(before, abs=2e-3)


def stop_one(robot: tool0.Robot) -> None:
    """Stop the arm's controller as the panel's button does."""
    trajectory_controller(robot).command_trajectory([])


def trajectory_controller(robot: tool0.Robot) -> tool0.Controller:
    name = next(c.name for c in robot.controllers() if "Trajectory" in c.type)
    return robot.controller(name)


@pytest.mark.parametrize("stop", [stop, stop_one])
def test_a_trajectory_without_a_goal_ends(
    robot: tool0.Robot, stop: Callable[[tool0.Robot], None]
) -> None:
    """The simulation does not end with it."""
    controller = trajectory_controller(robot)
    place = [joint(robot, name)[0] for name in robot.arm.joints]
    place[ELBOW] += 1.0
    points = [TrajectoryPoint(place, [0.0] * len(place), time_from_start=2.0)]
    controller.command_trajectory(points)
    robot.run(1.0)
    assert joint(robot, "elbow_joint")[1] > 0.3
    stop(robot)
    require_rest(robot)
    assert joint(robot, "elbow_joint")[0] < place[ELBOW] - 0.2
    goal = controller.follow(points)
    robot.run(3.0)
    assert goal.status is GoalStatus.SUCCEEDED, goal.result


def test_a_goal_is_preempted(robot: tool0.Robot) -> None:
    goals = robot.move_joints({"elbow_joint": 1.0}, duration=3.0)
    robot.run(1.0)
    stop(robot)
    assert {goal.status for goal in goals} == {GoalStatus.PREEMPTED}
    require_rest(robot)


def test_single_commands_end(tmp_path: Path) -> None:
    """A commanded speed becomes 0, and a joint that moves to a position holds."""
    file = tmp_path / "controllers.yaml"
    file.write_text(FORWARDING)
    control = ControlConfig(controllers_file=file, controllers="speed position")
    with tool0.bringup(control=control, realtime=False) as robot:
        robot.run(0.1)
        target = joint(robot, "elbow_joint")[0] + 1.0
        robot.controller("speed").command(0.5)
        robot.controller("position").command(target)
        robot.run(0.05)
        assert joint(robot, "wrist_3_joint")[1] > 0.2
        stop(robot)
        require_rest(robot)
        assert joint(robot, "elbow_joint")[0] < target - 0.3
        stop(robot)  # at rest, it changes nothing
        require_rest(robot)


@pytest.mark.slow
def test_a_standstill_of_the_process_ends_goals_with_the_reason() -> None:
    with tool0.bringup() as robot:
        (goal,) = robot.move_joints({"elbow_joint": 0.5}, duration=20.0)
        resume = ["sh", "-c", f"sleep 1.3; kill -CONT {os.getpid()}"]
        with subprocess.Popen(resume):
            os.kill(os.getpid(), signal.SIGSTOP)
        result = goal.wait(timeout=10.0)
        assert result.status is GoalStatus.PREEMPTED
        assert result.error_string.startswith("the simulator stood still for 1.")
