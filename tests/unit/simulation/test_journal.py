"""The journal has every request that changed the simulation, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import tool0
from tool0.errors import Tool0Error
from tool0.protocol.motion import MoveJoints, SteerJoints
from tool0.protocol.objects import ReadContacts
from tool0.protocol.running import Reset
from tool0.protocol.trajectories import CommandTrajectory, FollowTrajectory
from tool0.simulation import journal as journals
from tool0.simulation.handlers.table import entries
from tool0.simulation.journal import Journal


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def test_it_has_the_primitive_that_a_request_plans(robot: tool0.Robot) -> None:
    robot.run(0.01)
    robot.gripper.move(opening=0.04, speed=0.05)
    robot.go_to_pose("up")
    robot.channel.call(ReadContacts())
    grip, go = robot.simulation.journal.after()
    assert isinstance(grip.request, FollowTrajectory)
    assert grip.request.grip is not None
    assert grip.request.grip.speed == 0.05
    assert isinstance(go.request, MoveJoints)
    assert (grip.step, grip.tick, grip.time, grip.error) == (10, 10, 0.01, None)
    assert robot.simulation.journal.after(grip.number) == (go,)


def test_steps_go_on_after_a_reset(robot: tool0.Robot) -> None:
    robot.run(0.02)
    robot.reset()
    robot.run(0.01)
    robot.reset()
    first, second = robot.simulation.journal.after()
    assert (first.step, first.tick) == (20, 20)
    assert (second.step, second.tick) == (30, 10)
    assert robot.snapshot.step == 30
    assert robot.snapshot.tick == 0


def test_what_fails_is_noted_with_its_reason(robot: tool0.Robot) -> None:
    with pytest.raises(Tool0Error, match="nothing"):
        robot.scene.remove("nothing")
    (entry,) = robot.simulation.journal.after()
    assert entry.error is not None
    assert "nothing" in entry.error


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch, robot: tool0.Robot) -> Journal:
    """A journal that keeps four requests."""
    monkeypatch.setattr(journals, "MOST_REQUESTS", 4)
    return robot.simulation.journal


def test_a_full_journal_drops_the_oldest(small: Journal, robot: tool0.Robot) -> None:
    for n in range(7):
        robot.apply_wrench("tool0", force=(n, 0.0, 0.0), duration=0.0)
    assert [entry.number for entry in small.after()] == [3, 4, 5, 6]
    assert [entry.number for entry in small.after(4)] == [5, 6]
    assert small.after(6) == ()


def test_long_trajectories_count_more(
    monkeypatch: pytest.MonkeyPatch, robot: tool0.Robot
) -> None:
    monkeypatch.setattr(journals, "MOST_ITEMS", 250)
    joints, q = robot.arm.joint_names, list(robot.arm.joints.values())
    points = tuple(
        tool0.TrajectoryPoint(q, time_from_start=0.01 * (n + 1)) for n in range(100)
    )
    for _ in range(4):
        robot.channel.call(
            CommandTrajectory(
                controller="eff_joint_traj_controller",
                points=points,
                joint_names=joints,
            )
        )
    assert [entry.number for entry in robot.simulation.journal.after()] == [2, 3]


def test_many_are_read_in_pieces(
    monkeypatch: pytest.MonkeyPatch, robot: tool0.Robot
) -> None:
    monkeypatch.setattr(journals, "AT_ONCE", 3)
    for _ in range(5):
        robot.reset()
    journal = robot.simulation.journal
    first = journal.after()
    assert [entry.number for entry in first] == [0, 1, 2]
    assert [entry.number for entry in journal.after(first[-1].number)] == [3, 4]


def test_every_request_that_changes_something_runs_in_the_tick() -> None:
    changing = {entry.request for entry in entries().values() if entry.changes}
    assert {Reset, MoveJoints, SteerJoints, FollowTrajectory} <= changing
    assert all(entry.in_tick for entry in entries().values() if entry.changes)
    reading = [name for name, entry in entries().items() if not entry.changes]
    assert "read_gains" in reading
    assert "set_gains" not in reading
