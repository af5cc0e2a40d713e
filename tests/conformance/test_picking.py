"""A cube goes from the table into the bin, by friction alone; failures are told."""

from __future__ import annotations

import pytest
from conformance_types import BringUp

import tool0
from tool0.api.grasps import find_bin
from tool0.api.table import PickTable
from tool0.cli.demos.hand import PickOptions
from tool0.cli.demos.picker import pick_and_place
from tool0.cli.demos.trials import run_trials
from tool0.protocol.state import Snapshot

N_PICKS = 3


def start(bring_up: BringUp, **options: object) -> tool0.Robot:
    return bring_up(scene="table_and_bin", initial_pose="home", **options)


def test_cubes_from_anywhere_end_in_the_bin(bring_up: BringUp) -> None:
    robot = start(bring_up)
    into = find_bin(robot.scene.objects, "bin")
    poses = PickTable(scale=1.0).random_poses(robot, 0.045, seed=7)
    report = run_trials(
        robot, "cube", lambda: pick_and_place(robot, "cube", into), poses, N_PICKS
    )
    assert [pick.failure for pick in report.picks] == [None] * N_PICKS
    assert report.n_succeeded == N_PICKS
    starts = {pick.start[:2] for pick in report.picks}
    assert len(starts) == N_PICKS
    for pick in report.picks:
        assert pick.end is not None
        assert into.lower[1] < pick.end[1] < into.upper[1]
        assert pick.width == pytest.approx(0.045, abs=5e-4)
        assert pick.grip_force == pytest.approx(60.0, rel=0.1)
        # Neither the pads' impact nor letting go presses much harder than the grip.
        assert pick.grip_force <= pick.peak_force <= 1.5 * 60.0
        assert pick.slip is not None
        assert pick.slip <= 1e-3
        assert sum(pick.phases.values()) == pytest.approx(pick.duration, abs=0.05)


def test_what_slips_away_is_a_failure_with_a_reason(bring_up: BringUp) -> None:
    robot = start(bring_up)
    cube = robot.scene["cube"]
    robot.scene.remove("cube")
    robot.scene.add("cube", cube.geometry, xyz=cube.pose.xyz, mass=2.0, friction=0.02)
    into = find_bin(robot.scene.objects, "bin")
    report = pick_and_place(robot, "cube", into, PickOptions(force=20.0))
    assert not report.success
    assert report.failure is not None
    assert "holds nothing" in report.failure
    assert "while " in report.failure
    assert not into.holds(robot.scene.pose("cube"))


def test_what_is_out_of_reach_is_told_and_nothing_moves(bring_up: BringUp) -> None:
    robot = start(bring_up)
    before = dict(robot.joint_state.position)
    robot.scene.place("cube", (1.5, 0.0, 0.0))
    robot.run(0.01)
    into = find_bin(robot.scene.objects, "bin")
    report = pick_and_place(robot, "cube", into)
    assert not report.success
    assert "cannot be reached" in str(report.failure)
    after = robot.joint_state.position
    assert all(abs(after[name] - before[name]) < 0.02 for name in before)


def test_what_somebody_takes_away_is_a_failure(bring_up: BringUp) -> None:
    robot = start(bring_up)
    into = find_bin(robot.scene.objects, "bin")
    begun = robot.time

    def take_away(_: Snapshot) -> None:
        if robot.time > begun + 1.0 and "cube" in robot.scene:
            robot.scene.remove("cube")

    report = pick_and_place(robot, "cube", into, on_snapshot=take_away)
    assert not report.success
    assert "the object 'cube' is gone" in str(report.failure)
    assert report.end is None
