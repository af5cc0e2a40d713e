from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from arm_rig import old_urdf
from raises_naming import raises_naming
from ur5_rig import ARM, ARM_JOINTS, CONTROLLERS, HOME

import tool0
from tool0.description.posture import Branch
from tool0.description.transform import Pose, Transform, to_transform
from tool0.errors import ConfigError, ControlError, ModelError, UnreachableError
from tool0.motion import linear
from tool0.motion.path import Path as JointPath
from tool0.scene import Scene, SceneObject, Sphere

pytestmark = pytest.mark.slow

AT_HOME = dict(zip(ARM_JOINTS, HOME, strict=True))
AHEAD = Pose(xyz=(0.45, 0.2, 0.35), rpy=(np.pi, 0.0, 0.3))
BASE = "robotiq_arg2f_base_link"
PADS = Pose(xyz=(0.0, 0.0, 0.15), rpy=(0.0, 0.0, 0.4))


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False, initial_pose=AT_HOME) as robot:
        yield robot


def same(a: Transform, b: Transform | Pose, within: float = 1e-6) -> bool:
    matrix = (to_transform(b) if isinstance(b, Pose) else b).matrix
    return bool(np.abs(a.matrix - matrix).max() < within)


def wanted(robot: tool0.Robot, **where: object) -> Transform:
    """Return where the tool is to end up, once its controller is there."""
    positions = robot.controller(ARM).query_state(robot.time + 1e6).positions
    names = robot.controller(ARM).spec.joints
    robot.reset(dict(zip(names, positions, strict=True)))
    pose: Transform = robot.arm.pose(**where)  # type: ignore[arg-type]
    return pose


def test_poses_are_those_of_the_links(robot: tool0.Robot) -> None:
    arm = robot.arm
    assert robot.arms == {"arm": arm}
    assert (arm.name, arm.tip, arm.joint_names) == ("arm", "tool0", ARM_JOINTS)
    assert list(arm.joints) == list(ARM_JOINTS)
    assert arm.branch == Branch(shoulder="left", elbow="up", wrist="no_flip")
    assert same(arm.pose(), robot.pose("tool0"))
    assert same(arm.pose(tip=BASE), robot.pose(BASE))
    shoulder = "shoulder_link"
    T = robot.pose("tool0", relative_to=shoulder) @ to_transform(PADS)
    assert same(arm.pose(tool=PADS, relative_to=shoulder), T)


@pytest.mark.parametrize(
    "where",
    [
        {},
        {"tip": BASE},
        {"tool": PADS},
        {"tip": BASE, "tool": PADS, "relative_to": "base_link"},
    ],
    ids=lambda where: " ".join(where) or "tool0",
)
def test_every_way_to_say_a_pose_ends_there(
    where: dict[str, object], robot: tool0.Robot
) -> None:
    robot.arm.move_to(AHEAD, **where)  # type: ignore[arg-type]
    assert same(wanted(robot, **where), AHEAD)
    if where:
        above = Pose(xyz=(0.45, 0.2, 0.4), rpy=AHEAD.rpy)
        robot.arm.move_linear(above, **where)  # type: ignore[arg-type]
        assert same(wanted(robot, **where), above)


def test_a_transform_and_a_matrix_are_poses_too(robot: tool0.Robot) -> None:
    first, second, third = (
        robot.arm.inverse_kinematics(pose)
        for pose in (AHEAD, to_transform(AHEAD), to_transform(AHEAD).matrix)
    )
    assert first == second == third


def test_the_nearest_posture_is_taken_unless_another_is_asked_for(
    robot: tool0.Robot,
) -> None:
    arm = robot.arm
    every = arm.inverse_kinematics(AHEAD)
    assert every[0].branch == arm.branch
    flip = Branch(wrist="flip")  # a finger brushes the forearm on the way
    goal = arm.move_to(AHEAD, branch=flip, speed=1.0, collision="ignore")
    assert goal.wait(timeout=10.0).status is tool0.GoalStatus.SUCCEEDED
    assert arm.branch.wrist == "flip"
    last = every[-1]
    assert arm.inverse_kinematics(AHEAD, near=last.positions)[0].branch == last.branch


def test_motions_in_the_tools_own_frame_add_up(robot: tool0.Robot) -> None:
    """They count from where the arm is wanted, not from where it droops to."""
    start = robot.arm.pose()
    for _ in range(3):
        goal = robot.arm.move_linear(Pose(xyz=(0.0, 0.0, 0.03)), relative_to="tool0")
        assert goal.wait(timeout=5.0).status is tool0.GoalStatus.SUCCEEDED
    ahead = start @ Transform(position=(0.0, 0.0, 0.09))
    assert same(wanted(robot), ahead)


def test_a_line_begins_at_rest(robot: tool0.Robot) -> None:
    robot.arm.move_to(AHEAD)
    for _ in range(2):  # before its first tick, and on the way
        with raises_naming(ControlError, ARM):
            robot.arm.move_linear(AHEAD)
        robot.run(0.3)


def test_a_line_is_not_followed_by_an_arm_that_was_moved_meanwhile(
    robot: tool0.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan_line = linear.plan_line

    def plan(*arguments: object, **options: object) -> JointPath:
        robot.controller(ARM).steer({"elbow_joint": 1.2})
        robot.run(0.1)
        return plan_line(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(linear, "plan_line", plan)
    with pytest.raises(ControlError):
        robot.arm.move_linear(AHEAD)


def test_what_is_wrong_is_said_and_moves_nothing(robot: tool0.Robot) -> None:
    arm = robot.arm
    far = Pose(xyz=(2.0, 0.0, 0.0))
    for move in (arm.move_to, arm.move_linear):
        with pytest.raises(UnreachableError):
            move(far)
        with raises_naming(ModelError, "'tool'"):
            move(AHEAD, tip="tool")
        with raises_naming(ControlError, "'tool0'"):
            move(AHEAD, tip="left_inner_finger_pad")
        with raises_naming(ModelError, "'table'"):
            move(AHEAD, relative_to="table")
    with raises_naming(ControlError, "'elbow'"):
        arm.inverse_kinematics(AHEAD, near={"elbow": 1.0})
    with raises_naming(ControlError, "elbow_joint"):
        arm.inverse_kinematics(AHEAD, near={"elbow_joint": np.nan})
    with raises_naming(ControlError, "speed"):
        arm.move_to(AHEAD, speed=2.0)
    robot.run(0.1)
    assert robot.controller(ARM).state.desired.velocities == (0.0,) * 6


def test_without_a_controller_poses_are_solved_and_nothing_moves() -> None:
    with tool0.bringup(realtime=False, controllers="", initial_pose=AT_HOME) as robot:
        assert len(robot.arm.inverse_kinematics(AHEAD)) == 8
        with pytest.raises(ControlError):
            robot.arm.move_to(AHEAD)


def test_a_controller_may_have_other_joints_and_another_order(tmp_path: Path) -> None:
    joints = ["finger_joint", *reversed(ARM_JOINTS)]
    gains = ", ".join(f"{joint}: {{p: 1000, d: 30}}" for joint in joints)
    yaml = tmp_path / "one.yaml"
    yaml.write_text(
        "all:\n  type: effort_controllers/JointTrajectoryController\n"
        f"  joints: [{', '.join(joints)}]\n  gains: {{{gains}}}\n"
    )
    with tool0.bringup(
        realtime=False,
        controllers_file=yaml,
        controllers="all",
        initial_pose={**AT_HOME, "finger_joint": 0.3},
    ) as robot:
        robot.arm.move_linear(AHEAD)
        state = robot.controller("all")
        end = state.query_state(robot.time + 1e6).positions
        assert end[0] == pytest.approx(0.3, abs=1e-3)
        robot.reset(dict(zip(joints, end, strict=True)))
        assert same(robot.arm.pose(), AHEAD)


def test_a_persons_urdf_without_our_elements_has_an_arm(tmp_path: Path) -> None:
    robot_file = old_urdf(tmp_path)
    with tool0.bringup(robot=robot_file, realtime=False, controllers="") as robot:
        pose = Pose(xyz=(0.3, 0.2, 1.1), rpy=(np.pi, 0.0, 0.0))
        solution = robot.arm.inverse_kinematics(pose)[0]
        robot.reset(solution.positions)
        assert same(robot.arm.pose(), pose)


def test_robots_without_or_with_two_arms_say_so(tmp_path: Path) -> None:
    plain = old_urdf(tmp_path, kind="fixed")
    with tool0.bringup(robot=plain, realtime=False, controllers="") as robot:
        assert not robot.arms
        with raises_naming(ControlError, "'tool0'", "6"):
            _ = robot.arm
    cell = CONTROLLERS.parents[2] / "examples" / "cell" / "two_arms.urdf.xacro"
    with tool0.bringup(robot=cell, realtime=False, controllers="") as robot:
        assert sorted(robot.arms) == ["left", "right"]
        with pytest.raises(ControlError):
            _ = robot.arm


def test_values_in_another_unit_are_named(robot: tool0.Robot) -> None:
    in_mm = Pose(xyz=(400.0, 100.0, 300.0), rpy=(np.pi, 0.0, 0.0))
    arm = robot.arm
    for move in (arm.move_to, arm.move_linear, arm.inverse_kinematics):
        with pytest.raises(UnreachableError, match=r"mean 509\.\d+mm = 0\.5099 m"):
            move(in_mm)
    with pytest.raises(UnreachableError) as far:
        robot.arm.move_to(Pose(xyz=(2.0, 0.0, 0.3), rpy=(np.pi, 0.0, 0.0)))
    assert "did you mean" not in str(far.value)
    said = "speed: 250 m/s is no plausible speed; did you mean 250mm/s = 0.25 m/s?"
    with pytest.raises(ConfigError, match=said):
        robot.arm.move_linear(AHEAD, speed=250)


def test_an_object_far_away_is_a_warning() -> None:
    ball = Sphere(radius=0.02)
    near = SceneObject(name="near", geometry=ball, pose=Pose(xyz=(30.0, 0.0, 0.0)))
    far = SceneObject(name="far", geometry=ball, pose=Pose(xyz=(400.0, 0.0, 300.0)))
    with tool0.bringup(scene=Scene((near, far)), realtime=False) as robot:
        (warning,) = robot.warnings
    assert "far: the object is" in warning
    assert "positions are in metres; write 400mm or 0.4" in warning
