"""``tool0 demo pick``: what it prints, writes, and refuses."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import av
import pytest
from promised import require_gl

from tool0.cli import FAILED, GOAL_FAILED, OK, main
from tool0.cli.demos import monitor
from tool0.cli.demos.monitor import FrameRecorder

pytestmark = pytest.mark.slow


def test_a_pick_is_told_to_people_and_written_for_programs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "report.json"
    assert main(["demo", "pick", "--headless", "--report", str(path)]) == OK
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("'cube' from (0.549, 0.109): in the bin after ")
    assert "gripped with 60 N" in printed[0]
    assert printed[-1].startswith("1 of 1 in the bin; mujoco, mimic gripper, ")
    report = json.loads(path.read_text())
    assert report["succeeded"] == 1
    assert report["grasp_assist"] is False
    (pick,) = report["picks"]
    assert pick["success"]
    assert pick["slip"] < 1e-3
    assert next(iter(pick["phases"])) == "approaching"


def test_a_failed_pick_is_explained_and_is_the_status(
    capsys: pytest.CaptureFixture[str],
) -> None:
    slippery = ["--mass", "2", "--friction", "0.02", "--force", "20"]
    line = ["demo", "pick", "--headless", *slippery, "--json"]
    assert main(line) == GOAL_FAILED
    report = json.loads(capsys.readouterr().out)
    assert report["succeeded"] == 0
    assert "holds nothing" in report["picks"][0]["failure"]


def test_the_cheat_is_named_and_lifts_what_slips(
    capsys: pytest.CaptureFixture[str],
) -> None:
    slippery = ["--mass", "0.3", "--friction", "0.02", "--grasp-assist"]
    assert main(["demo", "pick", "--headless", *slippery]) == OK
    assert "grasp assist" in capsys.readouterr().out


def test_the_same_seed_draws_the_same_poses(
    capsys: pytest.CaptureFixture[str],
) -> None:
    starts = []
    for _ in range(2):
        line = ["demo", "pick", "--headless", "--seed", "3", "--json"]
        assert main(line) == OK
        report = json.loads(capsys.readouterr().out)
        starts.append([pick["start"] for pick in report["picks"]])
    assert starts[0] == starts[1]
    assert starts[0][0] != pytest.approx([0.5487, 0.1091, 0.0025], abs=1e-3)


def test_a_film_is_as_long_as_the_pick(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    require_gl()
    few = functools.partial(FrameRecorder, 10)  # frames a second: drawing takes long
    monkeypatch.setattr(monitor, "FrameRecorder", few)
    path = tmp_path / "pick.mp4"
    line = ["demo", "pick", "--headless", "--video", str(path), "--json"]
    assert main(line) == OK
    report = json.loads(capsys.readouterr().out)
    assert report["video"] == str(path)
    with av.open(str(path)) as film:
        (stream,) = film.streams.video
        duration = float(stream.frames / stream.average_rate)
    assert duration == pytest.approx(report["sim_time"], abs=0.2)


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--n", "0"], "--n must be 1 or more, got 0"),
        (["--size", "0.2"], "is 200.0 mm wide, and the gripper opens to 85.0 mm"),
        (["--force", "500"], "force 500.0 N is outside [20.0, 235.0] N"),
        (["--speed", "2"], "speed must be in [0.01, 1], got 2.0"),
        (["--video", "/nowhere/pick.mp4"], "/nowhere"),
        (["--report", "/nowhere/pick.json"], "/nowhere"),
        (["--report", "pick", "--video", "pick"], "are one file, pick"),
        (["--video", "pick.mp4", "--camera", "rist"], "did you mean 'wrist'?"),
    ],
)
def test_what_cannot_be_is_refused(
    arguments: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["demo", "pick", "--headless", *arguments]) == FAILED
    assert why in capsys.readouterr().err


def test_any_robot_picks_on_a_table_of_its_reach(
    capsys: pytest.CaptureFixture[str],
) -> None:
    starts = []
    for robot in (["--arm", "ur3e", "--gripper", "hande"], ["--arm", "ur20"]):
        assert main(["demo", "pick", "--headless", "--json", *robot]) == OK
        (pick,) = json.loads(capsys.readouterr().out)["picks"]
        starts.append(pick["start"][0])
    assert starts[0] < 0.5487 < starts[1]


def test_a_handover_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    line = ["demo", "handover", "--headless", "--taker", "ur5+2f85"]
    assert main(line) == OK
    printed = capsys.readouterr().out.splitlines()
    assert "in the bin after" in printed[0]
    assert printed[-1].startswith("1 of 1 in the bin")


def test_a_pick_from_a_shelf_goes_around_the_wall(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = ["demo", "shelf", "--headless", "--n", "2", "--json"]
    assert main(line) == OK
    first, second = json.loads(capsys.readouterr().out)["picks"]
    assert first["start"] == pytest.approx([0.37, 0.54, 0.2225], abs=1e-3)
    assert second["start"] != pytest.approx(first["start"], abs=1e-3)
    assert list(first["phases"])[:2] == ["approaching", "reaching in"]


def test_a_second_arm_makes_room_while_the_cube_is_carried(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = ["demo", "shelf", "--headless", "--second", "ur3e", "--json"]
    assert main(line) == OK
    (pick,) = json.loads(capsys.readouterr().out)["picks"]
    assert pick["success"]


def test_an_arm_that_is_too_short_for_the_shelf_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["demo", "shelf", "--headless", "--arm", "ur3e"]) == FAILED
    assert "too short for the shelf" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--giver", "ur5"], "--giver 'ur5' has no gripper; write ARM+GRIPPER"),
        (["--taker", "ur55+2f85"], "did you mean 'ur5'"),
        (["--taker", "ur5+2f58"], "did you mean '2f85'"),
    ],
)
def test_robots_that_cannot_hand_over_are_refused(
    arguments: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["demo", "handover", "--headless", *arguments]) == FAILED
    assert why in capsys.readouterr().err
