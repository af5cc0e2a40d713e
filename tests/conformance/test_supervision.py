"""Success means arrival: every way to move an arm, against every fault.

Whatever happens, no way reports a false success, the reason names the cause, the arm
comes to rest, and nothing moves again by itself.  ROS's nodes and UR's interfaces send
the requests of these ways; what they make of the outcomes is tested beside them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from conformance_types import BringUp
from ways_to_move import WAYS, Aim, Attempt

import tool0
from tool0 import TrajectoryPoint
from tool0.description.transform import Pose
from tool0.errors import ControlError, GoalTimeoutError, Tool0Error
from tool0.protocol.goals import GoalStatus, Tolerance
from tool0.scene import Box

ARRIVED = 0.1
"""The widest tolerance of any way [rad]."""
STILL = 0.02
"""[rad/s]"""
MOVED = 0.01
"""[rad]"""
UNLOCK_AFTER = 5.1
"""[s]"""
POSITIONS = "hardware_interface/PositionJointInterface"
ON_GAZEBO = {"goal of ROS 1", "path", "program, line"}
FAULTS_ON_GAZEBO = {
    "test_the_floor_in_the_way",
    "test_an_emergency_stop",
    "test_waiting_for_a_path_tells_how_it_ended",
}
"""Ways and faults that are also tested there."""
STREAMS = {"servo", "speed", "jog"}

Robot = Callable[[str], tool0.Robot]


@pytest.fixture
def robot_for(
    bring_up: BringUp, engine: str, tmp_path: Path, request: pytest.FixtureRequest
) -> Robot:
    """Bring a robot up for a way to move it."""

    def bring(name: str) -> tool0.Robot:
        is_there = name in ON_GAZEBO and request.function.__name__ in FAULTS_ON_GAZEBO
        if engine != "mujoco" and not is_there:
            pytest.skip("the supervision knows no engine: a few ways will do")
        more = {}
        if WAYS[name].controllers:
            file = tmp_path / "controllers.yaml"
            file.write_text(WAYS[name].controllers)
            more = {
                "controllers_file": file,
                "controllers": ("arm",),
                "transmission_hw_interface": POSITIONS,
            }
        robot = bring_up(arm="ur5", initial_pose="ready", **more)
        robot.run(0.2)
        return robot

    return bring


def aim(
    robot: tool0.Robot, *, down: float = 0.0, turn: float = 0.0, duration: float = 1.5
) -> Aim:
    """Return a place below the arm [m], or beside it [rad]."""
    here = robot.arm.pose()
    if down:
        x, y, z = here.position
        pose = Pose(xyz=(x, y, z - down), rpy=(math.pi, 0.0, math.pi / 2.0))
        found = robot.arm.inverse_kinematics(pose)[0].positions
        joints = tuple(found[name] for name in robot.arm.joint_names)
    else:
        joints = tuple(
            q + turn * (name == "shoulder_pan_joint")
            for name, q in robot.arm.joints.items()
        )
        x, y, z = here.position
        pose = Pose(
            xyz=(
                x * math.cos(turn) - y * math.sin(turn),
                x * math.sin(turn) + y * math.cos(turn),
                z,
            ),
            rpy=(math.pi, 0.0, math.pi / 2.0 + turn),
        )
    return Aim(joints, pose, duration)


def follow(robot: tool0.Robot, attempt: Attempt, duration: float) -> None:
    """Let time pass as its client does."""
    end = robot.time + duration
    while robot.time < end and attempt.outcome() in {"active", "none"}:
        attempt.feed()
        robot.run(0.02)
    attempt.feed()


def speed(robot: tool0.Robot) -> float:
    """Return that of the fastest joint of the arm [rad/s]."""
    snapshot = robot.snapshot
    names = snapshot.joint_names
    return max(abs(snapshot.velocity[names.index(j)]) for j in robot.arm.joint_names)


def require_rest(robot: tool0.Robot, attempt: Attempt | None) -> None:
    """Nothing moves, whatever its client goes on sending."""
    robot.run(1.2)  # a light wrist may spin at first, after a contact
    end = robot.time + 4.0  # and, in Gazebo, now and then longer
    while speed(robot) >= STILL and robot.time < end:
        robot.run(0.1)
    before = robot.arm.joints
    for _ in range(25):
        if attempt is not None:
            attempt.feed()
        robot.run(0.02)
        assert speed(robot) < STILL
    after = robot.arm.joints
    assert max(abs(after[name] - before[name]) for name in before) < MOVED


def require_no_false_success(robot: tool0.Robot, attempt: Attempt, goal: Aim) -> None:
    if attempt.outcome() == "succeeded":
        distances = [
            abs(q - robot.arm.joints[name])
            for name, q in zip(robot.arm.joint_names, goal.joints, strict=True)
        ]
        assert max(distances) < ARRIVED


# ---- something in the way ------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
def test_the_floor_in_the_way(robot_for: Robot, way: str) -> None:
    robot = robot_for(way)
    attempt = WAYS[way].start(robot, aim(robot, down=0.25))
    follow(robot, attempt, 2.0 if way == "hand guiding" else 4.0)
    assert attempt.outcome() in {"failed", "aborted", "none"}
    if way == "hand guiding":  # the hand feels it
        robot.clear_wrenches()
    else:
        assert "'ground'" in attempt.reason
        assert "_joint" in attempt.reason
    if attempt.outcome() != "none":
        require_rest(robot, attempt)
        assert not robot.snapshot.stalls


@pytest.mark.parametrize("way", WAYS)
def test_a_blocked_joint(robot_for: Robot, way: str) -> None:
    robot = robot_for(way)
    robot.scene.add("wall", Box(size=(0.4, 0.05, 1.0)), xyz=(0.5, -0.1, 0.4))
    attempt = WAYS[way].start(robot, aim(robot, turn=-0.8))
    follow(robot, attempt, 2.0 if way == "hand guiding" else 4.0)
    assert attempt.outcome() in {"failed", "aborted", "none"}
    if way == "hand guiding":
        robot.clear_wrenches()
    else:  # a goal may be judged while the arm rebounds
        assert "'wall'" in attempt.reason or "_joint" in attempt.reason
    if attempt.outcome() != "none":
        require_rest(robot, attempt)


# ---- impossible motions --------------------------------------------------------------


@pytest.mark.parametrize("way", [way for way in WAYS if way != "hand guiding"])
def test_a_target_beyond_limits_is_refused(robot_for: Robot, way: str) -> None:
    """Jogging and speeds have no target: they are told to be too fast."""
    robot = robot_for(way)
    joints = list(aim(robot).joints)
    joints[2] = 3.5  # the elbow's limit is pi
    far = Aim(tuple(joints), Pose(xyz=(3.0, 0.0, 0.5)), 1.5)
    if way in {"servo", "speed"}:
        far = far._replace(duration=0.05)
    if way == "jog":
        attempt = WAYS[way].start(robot, far)
        follow(robot, attempt, 1.5)
        model = robot.description.model
        for name, q in robot.arm.joints.items():
            limits = model.joint(name).limits
            assert limits.lower - MOVED <= q <= limits.upper + MOVED
        return
    try:
        attempt = WAYS[way].start(robot, far)
    except Tool0Error as error:
        told = str(error)
    else:  # a stream whose first targets are possible
        follow(robot, attempt, 2.0)
        told = attempt.reason
    assert "limit" in told or "reach" in told
    require_rest(robot, None)


@pytest.mark.parametrize("way", [way for way in WAYS if not WAYS[way].is_planned])
def test_too_short_a_time(robot_for: Robot, way: str) -> None:
    """Planned motions choose their own time."""
    robot = robot_for(way)
    goal = aim(robot, turn=1.0, duration=0.05)
    told = ""
    try:
        attempt = WAYS[way].start(robot, goal)
    except Tool0Error as error:
        told = str(error)
    if told:
        assert "rad/s" in told
        require_rest(robot, None)
        return
    follow(robot, attempt, 3.0)
    require_no_false_success(robot, attempt, goal)


# ---- stops ---------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
def test_a_stop_of_its_client(robot_for: Robot, way: str) -> None:
    robot = robot_for(way)
    attempt = WAYS[way].start(robot, aim(robot, turn=-0.6, duration=2.0))
    follow(robot, attempt, 0.4)
    attempt.cancel()
    robot.clear_wrenches()
    robot.run(0.1)
    assert attempt.outcome() != "succeeded"
    require_rest(robot, None)


@pytest.mark.parametrize("way", WAYS)
def test_an_emergency_stop(robot_for: Robot, way: str) -> None:
    robot = robot_for(way)
    attempt = WAYS[way].start(robot, aim(robot, turn=-0.6, duration=2.0))
    follow(robot, attempt, 0.4)
    robot.emergency_stop()
    require_rest(robot, attempt)
    assert attempt.outcome() not in {"succeeded", "active"}
    robot.emergency_stop(False)
    require_rest(robot, attempt)
    assert attempt.outcome() not in {"succeeded", "active"}
    assert way not in STREAMS or "take it again" in attempt.reason


@pytest.mark.parametrize("way", WAYS)
def test_a_protective_stop(robot_for: Robot, way: str) -> None:
    robot = robot_for(way)
    box = robot.arm.control_box
    attempt = WAYS[way].start(robot, aim(robot, turn=-0.6, duration=2.0))
    follow(robot, attempt, 0.4)
    box.stop_protectively("a test")
    require_rest(robot, attempt)
    assert attempt.outcome() not in {"succeeded", "active"}
    robot.run(UNLOCK_AFTER - 1.7)
    box.unlock()
    box.play()
    require_rest(robot, attempt)
    assert attempt.outcome() not in {"succeeded", "active"}
    assert way not in STREAMS or "take it" in attempt.reason


# ---- what clients choose -------------------------------------------------------------


@pytest.mark.parametrize("dialect", ["goal of ROS 1", "goal of ROS 2"])
def test_a_client_can_switch_the_check_off(robot_for: Robot, dialect: str) -> None:
    """With -1, as in ROS: the goal succeeds wherever the joints are."""
    robot = robot_for(f"{dialect} without tolerances")
    down, names = aim(robot, down=0.25), robot.arm.joint_names
    goal = robot.controller("arm").follow(
        [TrajectoryPoint(down.joints, [0.0] * 6, time_from_start=1.5)],
        joint_names=names,
        goal_tolerance=dict.fromkeys(names, Tolerance(-1.0, -1.0)),
    )
    assert goal.wait(5.0).status is GoalStatus.SUCCEEDED


def test_waiting_for_a_path_tells_how_it_ended(robot_for: Robot) -> None:
    robot = robot_for("path")
    motion = robot.arm.motion
    with motion.taken():
        motion.execute_path([1.0], [aim(robot, turn=0.3).joints], [[0.0] * 6])
        with pytest.raises(GoalTimeoutError):
            motion.wait(0.2)
        motion.wait(5.0)
        assert motion.state.is_done
        motion.execute_path([1.5], [aim(robot, down=0.25).joints], [[0.0] * 6])
        with pytest.raises(ControlError, match=r"failed: joint '.*'ground'"):
            motion.wait(5.0)
        assert not motion.state.is_done
        with pytest.raises(ControlError, match="take it again"):
            motion.execute_path([1.0], [aim(robot, turn=0.3).joints], [[0.0] * 6])
        robot.run(1.0)  # what hit the ground comes to rest
        motion.take()
        motion.speed_joints([0.0, -0.2, 0.0, 0.0, 0.0, 0.0], duration=0.5)
        robot.run(1.0)
        assert not motion.state.failure
