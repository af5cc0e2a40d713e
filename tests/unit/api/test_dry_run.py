"""A dry run says what a program would do, from where the robot is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from raises_naming import raises_naming

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ProgramError

PAN = "shoulder_pan_joint"


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5e", realtime=False, scene="table_and_bin") as robot:
        yield robot


def program(folder: Path, *steps: str) -> Path:
    file = folder / "program.yaml"
    file.write_text(
        "name: trial\ntool: {xyz: [0, 0, 0.1418]}\nsteps:\n"
        + "".join(f"  - {{{step}}}\n" for step in steps)
    )
    return file


PICK = (
    "kind: gripper, opening: open",
    "kind: move_joint, pose: {xyz: [0.5487, 0.1091, 0.2], rpy: [180deg, 0, 0]}",
    "kind: move_linear, pose: {xyz: [0.5487, 0.1091, 0.0025], rpy: [180deg, 0, 0]}",
    "kind: gripper, opening: closed, force: 40, must_hold: true",
    "kind: move_joint, named_pose: up",
)


@pytest.mark.slow
def test_it_ends_as_the_program_does_and_moves_nothing(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    (goal,) = robot.move_joints({PAN: 0.3}, speed=1.0)
    goal.wait()
    robot.arm.control_box.set_speed_slider(0.5)
    robot.run(1.0)
    before, file = robot.snapshot, program(tmp_path, *PICK)
    found = robot.programs.dry_run(file)
    assert robot.snapshot == before
    end = robot.run_program(file).wait()
    assert (found.end.state, end.state) == ("succeeded", "succeeded")
    assert found.end.time == pytest.approx(end.time, abs=0.1)
    assert {touch.second for touch in found.touches} == {"cube"}
    assert not found.has_collided
    assert 0.1 < found.speed.share < 0.6  # of the slider's half
    assert found.effort.joint == "shoulder_lift_joint"
    assert 5.0 < found.effort.value < 150.0


def test_a_collision_is_one_of_the_arm(tmp_path: Path) -> None:
    with tool0.bringup(arm="ur5e", realtime=False, scene=wall()) as walled:
        home = "kind: move_joint, named_pose: home"
        found = walled.programs.dry_run(program(tmp_path, home, *SWING))
    assert found.has_collided
    (arm, *_) = [touch for touch in found.touches if touch.is_of_arm]
    assert "wall" in {arm.first, arm.second}
    assert arm.time > 0.1
    assert arm.force > 1.0


SWING = (
    "kind: move_joint, joints: {shoulder_pan_joint: 90deg, shoulder_lift_joint: -90deg,"
    " elbow_joint: 90deg, wrist_1_joint: -90deg, wrist_2_joint: -90deg,"
    " wrist_3_joint: 0}",
)


def wall() -> Scene:
    """Beside the arm, at the height of its forearm."""
    box, pose = Box(size=(0.8, 0.05, 1.2)), Pose(xyz=(0.5, 0.35, 0.6))
    return Scene((SceneObject(name="wall", geometry=box, pose=pose),))


@pytest.mark.slow
def test_what_has_changed_since_the_start_is_there(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    robot.scene.place("cube", (0.4, -0.3, 0.05))
    robot.run(0.5)
    found = robot.programs.dry_run(program(tmp_path, *PICK))
    assert found.end.state == "failed"
    assert "step 4" in found.end.error


def test_a_program_that_cannot_be_executed_is_refused(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    far = "kind: move_linear, pose: {xyz: [3, 0, 0.2], rpy: [180deg, 0, 0]}"
    with raises_naming(ProgramError, "step 1", "program.yaml:4"):
        robot.programs.dry_run(program(tmp_path, far))
