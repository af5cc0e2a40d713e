"""Policies in episodes of a task: results, limits, latency, and what is written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from policies_for_tests import Reach
from raises_naming import raises_naming

from tool0.cli import FAILED, OK, main
from tool0.errors import ConfigError, PolicyError
from tool0.policy import ChunkOptions, EpisodeRun, RunOptions, evaluate, wilson

HERE = Path(__file__).parent / "policies_for_tests.py"


def policy(name: str) -> str:
    return f"{HERE}:{name}"


def runs(name: str, n: int = 2, **options: Any) -> list[EpisodeRun]:
    found: list[EpisodeRun] = []
    evaluate(policy(name), "Reach", range(n), when_ended=found.append, **options)
    return found


def test_a_policy_that_works_succeeds() -> None:
    report = evaluate(policy("Reach"), "Reach", range(4))
    assert (report.n_episodes, report.n_succeeded) == (4, 4)
    assert report.success_rate == 1.0
    assert report.interval == (pytest.approx(0.5101, abs=1e-4), 1.0)
    assert report.policy_time[0] > 0.0


def test_a_function_itself_is_a_policy_and_has_a_name(tmp_path: Path) -> None:
    found = evaluate(Reach, "Reach", [0], folder=tmp_path / "run")
    assert found.n_succeeded == 1
    assert json.loads((tmp_path / "run/report.json").read_text())["policy"] == "Reach"


def test_the_same_seed_is_the_same_episode() -> None:
    first, again = (runs("Reach", n)[1] for n in (2, 3))
    assert first.episode is not None
    assert again.episode is not None
    np.testing.assert_array_equal(first.episode.actions, again.episode.actions)


def test_late_actions_make_it_worse_and_nothing_moves_before_the_first() -> None:
    late = RunOptions(latency=0.15)
    found = runs("Reach", 1, run=late)[0]
    assert found.n_held > 2
    assert found.episode is not None
    np.testing.assert_array_equal(found.episode.actions[:3, :4], 0.0)
    in_time = runs("Reach", 1)[0]
    assert (found.result, in_time.result) == ("failure", "success")


def test_shorter_parts_of_chunks_are_more_exact() -> None:
    whole = runs("ReachFar", 1)[0]
    part = runs("ReachFar", 1, run=RunOptions(chunks=ChunkOptions(execute=1)))[0]
    assert part.result == "success"
    assert part.n_steps < whole.n_steps
    assert len(part.latencies) == part.n_steps
    assert len(whole.latencies) == -(-whole.n_steps // 20)


def test_an_action_beyond_the_limits_ends_the_episode_and_clipping_does_not() -> None:
    stopped = runs("Overshooting", 1)[0]
    assert stopped.result == "stopped"
    assert "it must be -1 … 1" in stopped.reason
    clipped = runs("Overshooting", 1, run=RunOptions(clips=True))[0]
    assert clipped.result == "success"
    assert runs("NotANumber", 1)[0].reason.endswith("the action for 'x' is nan")


def test_a_policy_that_fails_is_named_with_its_line() -> None:
    with raises_naming(PolicyError, "policies_for_tests.py:", "KeyError: 'weights'"):
        evaluate(policy("Failing"), "Reach", [0])
    with raises_naming(PolicyError, "shape (3,)", "(5,) or (h, 5)"):
        evaluate(policy("TooShort"), "Reach", [0])
    with raises_naming(ConfigError, "no function or class 'Reah'", "'Reach'"):
        evaluate(policy("Reah"), "Reach", [0])


def test_a_folder_has_everything(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run = RunOptions(max_steps=2)
    evaluate(policy("Reach"), "Reach", [5], run=run, folder=folder, videos="failures")
    (row,) = map(json.loads, (folder / "episodes.jsonl").read_text().splitlines())
    assert (row["seed"], row["result"], row["steps"]) == (5, "failure", 2)
    assert len(row["latencies"]) == 2
    table = pq.read_table(folder / "data/episode_000000.parquet")
    assert table.num_rows == 2
    assert {"observation", "action", "reward", "success"} <= set(table.column_names)
    report = json.loads((folder / "report.json").read_text())
    assert (report["task"], report["succeeded"]) == ("Reach", 0)
    assert len(report["policy_sha256"]) == 64
    (video,) = (folder / "videos").iterdir()
    assert video.name == "episode_000000_failure.mp4"
    assert video.stat().st_size > 1000
    with raises_naming(ConfigError, "has files already"):
        evaluate(policy("Reach"), "Reach", [5], folder=folder)


def test_the_command_prints_each_episode_and_the_rate(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ["policy", "run", policy("Reach"), "--task", "Reach", "--episodes", "2"]
    assert main(words) == OK
    first, _, last = capsys.readouterr().out.splitlines()
    assert first.startswith("seed 0: success, ")
    assert last.startswith("2 of 2 episodes succeeded: 100.0%, 95 % interval 34.2% to ")
    assert main([*words, "--json", "--seed", "7"]) == OK
    assert json.loads(capsys.readouterr().out)["succeeded"] == 2


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        ("--task Reach --rate 20", "--rate needs a bringup"),
        ("--episodes 3", "--episodes needs --task"),
        ("--latency 0.1", "--latency needs --task"),
        ("--task Reach --latency soon", "or 'measured'"),
        ("--task Reach --key a=b", "openpi server"),
        ("--task Reach --episodes 0", "--episodes must be 1 or more"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    words: str, shown: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["policy", "run", policy("Reach"), *words.split()]) == FAILED
    assert shown in capsys.readouterr().err


def test_wilsons_interval() -> None:
    # Brown, Cai, DasGupta 2001 (doi:10.1214/ss/1009213286): 8 of 10
    assert wilson(8, 10) == (
        pytest.approx(0.4902, abs=1e-4),
        pytest.approx(0.9433, abs=1e-4),
    )
    assert wilson(0, 20)[0] == 0.0
    assert wilson(0, 0) == (0.0, 1.0)
