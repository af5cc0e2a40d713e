"""What must not happen: an arm that is thrown, a push that nobody notices."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
from conformance_types import BringUp
from ur5_rig import ARM, ARM_JOINTS, HOME, point

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ControlError

PAN, LIFT, ELBOW, WRIST_3 = (ARM_JOINTS[k] for k in (0, 1, 2, 5))
AT_REST = [0.0] * 6
WALL = SceneObject(
    name="wall",
    geometry=Box(size=(0.6, 0.1, 0.8)),
    pose=Pose(xyz=(0.6, 0.35, 0.3)),
)
"""Beside the arm: it meets the wrist at a pan of 0.32 rad."""
INTO_THE_WALL = (1.2, *HOME[1:])
UNCHECKED = {joint: -1.0 for joint in ARM_JOINTS}
POSITION_YAML = """
joint_state_controller: {type: joint_state_controller/JointStateController, publish_rate: 50}
eff_joint_traj_controller:
  type: position_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, wrist_2_joint, wrist_3_joint]
  stop_trajectory_duration: 0.5
"""  # noqa: E501
EFFORT_YAML = """
wrist_effort_controller: {type: effort_controllers/JointEffortController, joint: wrist_3_joint}
"""  # noqa: E501


def joint(robot: tool0.Robot, name: str) -> tuple[float, float, float]:
    """Return position, velocity and effort of one joint."""
    state = robot.joint_state
    return state.position[name], state.velocity[name], state.effort[name]


def run_and_watch(
    robot: tool0.Robot, name: str, duration: float
) -> tuple[float, float, float]:
    """Let time pass; return a joint's lowest and highest position and largest speed."""
    seen = []
    for _ in range(round(duration / 0.008)):
        robot.run(0.008)
        seen.append(joint(robot, name))
    places, speeds = [p for p, _, _ in seen], [abs(v) for _, v, _ in seen]
    return min(places), max(places), max(speeds)


def test_a_goal_that_is_too_fast_stops_the_joint_where_it_is(bring_up: BringUp) -> None:
    start = {**dict(zip(ARM_JOINTS, HOME, strict=True)), ELBOW: 1.4}
    robot = bring_up(initial_pose=start)
    robot.run(0.5)
    there = [-1.4 if name == ELBOW else q for name, q in start.items()]
    goal = robot.controller(ARM).follow([point(there, 0.05, AT_REST)])
    lowest, _, fastest = run_and_watch(robot, ELBOW, 2.0)
    assert goal.status is tool0.GoalStatus.ABORTED
    assert fastest < 3.14  # 9.9 rad/s if the stop begins at the desired velocity
    assert lowest > 0.5
    _, velocity, effort = joint(robot, ELBOW)
    assert abs(velocity) < 0.01
    assert abs(effort) < 40.0


def test_a_named_motion_that_needs_too_much_speed_is_refused(
    robot: tool0.Robot,
) -> None:
    before = robot.snapshot.setpoints()[ELBOW].target
    with pytest.raises(ControlError) as refused:
        robot.move_joints({ELBOW: -1.2}, duration=0.05)
    for fact in (ELBOW, "83.1 rad/s", "3.14 rad/s", "1.4 s"):
        assert fact in str(refused.value)
    assert robot.snapshot.setpoints()[ELBOW].target == before
    (goal,) = robot.move_joints({ELBOW: -1.2}, duration=1.4)
    assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED


@pytest.mark.parametrize("duration", [5e-324, 1e-9])
def test_no_duration_is_too_short_to_be_refused(
    robot: tool0.Robot, duration: float
) -> None:
    with pytest.raises(ControlError, match="elbow_joint"):
        robot.move_joints({ELBOW: 0.0}, duration=duration)


def test_an_abort_names_the_contact(bring_up: BringUp) -> None:
    robot = bring_up(scene=Scene((WALL,)))
    goal = robot.controller(ARM).follow([point(INTO_THE_WALL, 6.0, AT_REST)])
    result = goal.wait(10.0)
    assert isinstance(result, tool0.GoalResult)
    assert result.status is tool0.GoalStatus.ABORTED
    assert result.error_code == tool0.GoalResult.PATH_TOLERANCE_VIOLATED
    assert PAN in result.error_string
    assert "'wall'" in result.error_string


@pytest.mark.parametrize("interface", ["effort", "position"])
def test_a_push_is_reported_and_a_stop_ends_it(
    bring_up: BringUp,
    interface: str,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    options: dict[str, object] = {}
    if interface == "position":
        yaml = tmp_path / "position.yaml"
        yaml.write_text(POSITION_YAML)
        options = {
            "gripper": None,
            "controllers_file": yaml,
            "controllers": ["joint_state_controller", ARM],
            "transmission_hw_interface": "hardware_interface/PositionJointInterface",
        }
    robot = bring_up(scene=Scene((WALL,)), **options)
    arm = robot.controller(ARM)
    with caplog.at_level(logging.WARNING):
        arm.follow([point(INTO_THE_WALL, 6.0, AT_REST)], path_tolerance=UNCHECKED)
        robot.run(4.0)
    (stall,) = robot.snapshot.stalls
    assert stall.joint == PAN
    assert abs(stall.effort) == pytest.approx(150.0, rel=0.1)
    assert [other for _, other in stall.contacts] == ["wall"]
    messages = [r.message for r in caplog.records if PAN in r.message]
    assert len(messages) == 1
    assert "'wall'" in messages[0]

    before, _, _ = joint(robot, PAN)
    arm.command_trajectory([])
    robot.run(2.0)
    after, _, effort = joint(robot, PAN)
    assert robot.snapshot.stalls == ()
    assert after == pytest.approx(before, abs=0.01)
    assert abs(effort) < 20.0


def test_a_joint_that_holds_a_load_is_not_reported(robot: tool0.Robot) -> None:
    robot.move_joints({LIFT: -0.3, ELBOW: 0.0}, speed=0.5)
    robot.run(6.0)
    assert robot.snapshot.stalls == ()


def test_a_raw_effort_keeps_a_light_joint_within_its_limits(
    bring_up: BringUp, tmp_path: Path
) -> None:
    yaml = tmp_path / "effort.yaml"
    yaml.write_text(EFFORT_YAML)
    robot = bring_up(
        gripper=None, controllers_file=yaml, controllers=["wrist_effort_controller"]
    )
    limits = robot.joint_limits[WRIST_3]
    robot.controller("wrist_effort_controller").command(20.0)
    _, highest, fastest = run_and_watch(robot, WRIST_3, 3.0)
    assert fastest <= 1.02 * limits.velocity
    assert limits.upper - 0.01 < highest <= limits.upper + 0.05
