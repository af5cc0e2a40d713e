"""Named poses of a robot: in its file, and by the facade."""

from __future__ import annotations

import math
import multiprocessing
import threading
from collections.abc import Iterator
from pathlib import Path
from xml.dom.minidom import Document

import pytest
from ur5_rig import ARM, ARM_JOINTS, POST, POST_GRIPPER

import tool0
from tool0.description.model import Link, RobotModel
from tool0.description.poses import LONGEST_NAME, PoseStore, poses_file
from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError, ControlError

PAN = ARM_JOINTS[0]
POSE = {"elbow_joint": 1.5708, "wrist_1_joint": -1e-05}


def open_book() -> PoseStore:
    """Return the poses of a robot of no arm that is called ur5."""
    model = RobotModel(name="ur5", root="world", links=(Link(name="world"),), joints=())
    source = Path("ur5.urdf")
    return PoseStore(RobotDescription(model=model, source=source, _document=Document()))


def saved(book: PoseStore) -> dict[str, dict[str, float]]:
    return {name: dict(pose.positions) for name, pose in book.all().items()}


def save_many(who: str) -> None:
    for number in range(20):
        open_book().save(f"{who} {number}", POSE)


@pytest.fixture
def book(data_home: Path) -> PoseStore:
    return open_book()


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def test_the_file_is_where_a_desktop_keeps_data(
    data_home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert poses_file("ur5") == data_home / "tool0" / "poses" / "ur5.yaml"
    home = Path.home() / ".local" / "share"
    for relative in ("", "data"):
        monkeypatch.setenv("XDG_DATA_HOME", relative)
        assert poses_file("ur5") == home / "tool0" / "poses" / "ur5.yaml"


def test_no_name_of_a_robot_leads_out_of_the_folder() -> None:
    folder = poses_file("ur5").parent
    for name in ("../../etc/x", "a/b", "..", "机器人", "my arm"):
        assert poses_file(name).parent == folder


def test_reading_creates_no_file(book: PoseStore) -> None:
    assert book.all() == {}
    assert not book.file.parent.exists()


def test_an_edited_pose_may_have_units(book: PoseStore) -> None:
    write(book.file, "up: {elbow: 90deg, slide: 40mm, wrist: !degrees -90, hand: 8}")
    assert saved(book)["up"] == pytest.approx(
        {"elbow": math.pi / 2.0, "slide": 0.04, "wrist": -math.pi / 2.0, "hand": 8.0}
    )


@pytest.mark.parametrize(
    "name", ["over the box", "on", "1", "a/b", "取料", "a: b", "~"]
)
def test_a_saved_pose_is_read_exactly(book: PoseStore, name: str) -> None:
    book.save("first", {})
    book.save(name, POSE)
    assert saved(book) == saved(open_book()) == {"first": {}, name: POSE}
    book.delete("first")
    assert saved(open_book()) == {name: POSE}


def test_an_update_keeps_the_positions_of_other_joints(book: PoseStore) -> None:
    book.save("work", {"left_elbow": 1.0, "right_elbow": 2.0})
    book.save("work", {"right_elbow": 3.0}, update=True)
    assert saved(book) == {"work": {"left_elbow": 1.0, "right_elbow": 3.0}}
    book.save("work", {"right_elbow": 4.0})
    assert saved(book) == {"work": {"right_elbow": 4.0}}


def test_a_pose_that_another_process_saves_is_seen(book: PoseStore) -> None:
    book.save("a", POSE)
    assert list(book.all()) == ["a"]
    open_book().save("b", POSE)
    assert list(book.all()) == ["a", "b"]


@pytest.mark.slow
def test_two_processes_and_two_threads_lose_no_pose(book: PoseStore) -> None:
    context = multiprocessing.get_context("spawn")
    workers = [
        kind(target=save_many, args=(f"{kind.__name__} {number}",))
        for kind in (context.Process, threading.Thread)
        for number in range(2)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(book.all()) == 80
    left = {item.name for item in book.file.parent.iterdir()}
    assert left == {"ur5.yaml", "ur5.lock"}


@pytest.mark.parametrize(
    ("text", "line", "names"),
    [
        ("home: {elbow_joint: 1\n", 2, ""),
        ("a: {}\nb: [1]\n", 2, "'b'"),
        ("a:\n  elbow_joint: far\n", 2, "'elbow_joint' of pose 'a'"),
        ("a:\n  elbow_joint: .inf\n", 2, "inf"),
        ("a:\n  elbow_joint: {x: 1}\n", 2, "'elbow_joint'"),
        ("a: {}\nb: {}\na: {}\n", 3, "'a'"),
        ("- a\n", 1, ""),
        ("? [a]\n: {}\n", 1, ""),
    ],
)
def test_a_broken_file_is_reported_by_line_and_not_changed(
    book: PoseStore, text: str, line: int, names: str
) -> None:
    write(book.file, text)
    for access in (book.all, lambda: book.save("new", POSE), lambda: book.delete("a")):
        with pytest.raises(ConfigError) as error:
            access()
        assert names in str(error.value)
        assert error.value.location is not None
        assert error.value.location.file == book.file
        assert error.value.location.line == line
    assert book.file.read_text(encoding="utf-8") == text


def test_a_file_that_is_no_text_and_a_folder_that_cannot_be_made_are_refused(
    book: PoseStore,
) -> None:
    write(book.file, "")
    assert book.all() == {}
    book.file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError):
        book.all()
    book.file.unlink()
    book.file.parent.rmdir()
    write(book.file.parent, "in the way")
    with pytest.raises(ConfigError) as error:
        book.save("a", POSE)
    assert str(book.file) in str(error.value)


def test_built_in_poses_come_first_and_cannot_be_changed(robot: tool0.Robot) -> None:
    own = list(robot.poses())
    assert {"home", "ready", "zero"} <= set(own)
    assert not any(pose.saved for pose in robot.poses().values())
    robot.save_pose("a")
    assert list(robot.poses()) == [*own, "a"]
    assert robot.poses()["a"].saved
    robot.save_pose("a")  # replaces it
    robot.delete_pose("a")
    assert list(robot.poses()) == own
    with pytest.raises(ControlError) as error:
        robot.delete_pose("a")
    assert "'a'" in str(error.value)
    write(poses_file(robot.description.model.name), f"home: {{{PAN}: 1.0}}\n")
    assert not robot.poses()["home"].saved  # the built-in one hides it
    for change in (robot.save_pose, robot.delete_pose):
        with pytest.raises(ControlError) as error:
            change("home")
        assert "'home'" in str(error.value)


def test_a_saved_pose_can_be_reached_and_be_the_initial_one(
    robot: tool0.Robot,
) -> None:
    robot.move_joints({PAN: 0.5, "finger_joint": 0.3}, speed=1.0)
    robot.run(3.0)
    robot.save_pose("here")
    positions = robot.poses()["here"].positions
    assert list(positions) == [*ARM_JOINTS, "finger_joint"]
    assert positions[PAN] == pytest.approx(0.5, abs=1e-3)
    assert positions["finger_joint"] == pytest.approx(0.3, abs=1e-3)
    for goal in robot.go_to_pose("home", speed=1.0):
        assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
    assert abs(robot.joint_state.position[PAN]) < 0.01
    (arm,) = robot.go_to_pose("here")
    assert arm.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
    robot.run(1.0)
    assert robot.joint_state.position[PAN] == pytest.approx(0.5, abs=1e-3)
    with tool0.bringup(realtime=False, initial_pose="here") as next_one:
        position = next_one.joint_state.position
        assert position[PAN] == pytest.approx(0.5, abs=1e-3)
        assert position["finger_joint"] == pytest.approx(0.3, abs=1e-3)


def test_a_pose_of_the_arm_leaves_the_gripper_as_it_is(robot: tool0.Robot) -> None:
    robot.move_joints({"finger_joint": 0.5, PAN: 0.1}, speed=1.0)
    robot.run(2.0)
    for go in (robot.go_to_pose, robot.arm.go_to_pose):
        for name in ("home", "ready"):
            (goal,) = go(name, speed=1.0)
            assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
    assert robot.joint_state.position["finger_joint"] == pytest.approx(0.5, abs=1e-3)
    before = robot.joint_state.position[PAN]
    (goal,) = robot.go_to_pose("closed", speed=1.0)
    goal.wait(5.0)
    assert robot.joint_state.position["finger_joint"] > 0.75
    assert robot.joint_state.position[PAN] == pytest.approx(before, abs=1e-3)


def test_poses_of_a_cell_know_the_grippers_of_every_arm(tmp_path: Path) -> None:
    cell = tmp_path / "cell.yaml"
    cell.write_text(
        "robots:\n"
        "  - {name: left, arm: ur5, gripper: 2f85}\n"
        "  - {name: right, arm: ur5e, gripper: hande, base: {xyz: [2, 0, 0]}}\n"
    )
    with tool0.bringup(cell=cell, realtime=False) as r:
        joints = {"left_finger_joint", "right_hande_left_finger_joint"}
        poses = r.simulation.poses
        named = poses.own["home"].positions
        assert poses.goal("home").keys() == named.keys() - joints
        assert not poses.goal("home", "right").keys() & joints
        assert poses.goal("open").keys() == joints


def test_a_pose_at_a_limit_can_be_reached_again(robot: tool0.Robot) -> None:
    robot.gripper.move(opening=0.0)
    robot.run(2.0)
    robot.save_pose("closed tight")
    robot.go_to_pose("open")
    robot.run(2.0)
    robot.go_to_pose("closed tight")


def test_a_pose_that_no_controller_can_reach_is_refused() -> None:
    files = [POST, POST_GRIPPER]
    with tool0.bringup(realtime=False, controllers_file=files) as robot:
        with pytest.raises(ControlError) as error:
            robot.go_to_pose("open")
        assert "'finger_joint'" in str(error.value)
        assert robot.controller(ARM).state.desired.velocities == (0.0,) * 6


@pytest.mark.slow
def test_an_unknown_pose_is_refused_with_the_nearest(robot: tool0.Robot) -> None:
    with pytest.raises(ControlError) as error:
        robot.go_to_pose("hom")
    assert "'home'" in str(error.value)
    with pytest.raises(ConfigError) as refused:
        tool0.bringup(realtime=False, initial_pose="hom")
    assert "'home'" in str(refused.value)


@pytest.mark.parametrize("name", ["", " ", "a ", "a\nb", "a\x00", "x" * 61, "\u200b"])
def test_a_name_that_nobody_could_read_is_refused(book: PoseStore, name: str) -> None:
    with pytest.raises(ControlError) as error:
        book.save(name, POSE)
    assert repr(name) in str(error.value)
    book.save("x" * LONGEST_NAME, POSE)


def test_a_broken_file_hides_no_built_in_pose(robot: tool0.Robot) -> None:
    write(poses_file(robot.description.model.name), "a: [")
    with pytest.raises(ConfigError):
        robot.poses()
    robot.go_to_pose("home")
    with tool0.bringup(realtime=False, initial_pose="ready"):
        pass


def test_it_names_every_controller_that_the_yaml_defines(robot: tool0.Robot) -> None:
    assert dict(robot.info.defined_controllers) == {
        "joint_state_controller": "joint_state_controller/JointStateController",
        "eff_joint_traj_controller": "effort_controllers/JointTrajectoryController",
        "gripper_controller": "effort_controllers/JointTrajectoryController",
        "joint_group_eff_controller": "effort_controllers/JointGroupEffortController",
    }
    assert next(iter(robot.info.defined_controllers)) == "joint_state_controller"
    assert (robot.control_period, robot.is_realtime) == (0.001, False)


def test_initial_values_of_ros2_control_go_before_home_and_after_a_given_pose() -> None:
    start = {"elbow_joint": 0.3}
    with tool0.bringup(ros2_control=True, initial_pose=start, realtime=False) as robot:
        positions = robot.snapshot.positions
    assert positions["elbow_joint"] == pytest.approx(0.3)
    assert positions["shoulder_lift_joint"] == pytest.approx(-1.57)
    with tool0.bringup(ros2_control=True, initial_pose="home", realtime=False) as robot:
        positions = robot.snapshot.positions
    assert positions["elbow_joint"] == pytest.approx(1.5708)
