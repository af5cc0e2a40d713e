"""``tool0 replay FILE --simulate`` repeats a recording, ``--compare`` beside it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import tool0
from tool0.cli import FAILED, main


def test_it_says_whether_a_recording_repeats(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from tool0.protocol.recordings import StartRecording, StopRecording

    file = tmp_path / "motion.mcap"
    with tool0.bringup(realtime=False) as robot:
        robot.channel.call(StartRecording(file=str(file)))
        robot.move_joints({"elbow_joint": 1.0})
        robot.run(0.2)
        robot.channel.call(StopRecording())
    assert main(["replay", str(file), "--simulate"]) == 0
    assert "identical: 26 frames, 0.20 s, 1 request\n" in capsys.readouterr().out
    assert main(["replay", str(file), "--simulate", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["is_identical"]
    assert (found["frames"], found["requests"], found["divergence"]) == (26, 1, None)
    assert main(["replay", str(file), "--compare", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["joints"]["elbow_joint"]["position_most"] == 0.0
    assert (found["lag"], found["notes"]) == (0.0, [])
    for words, problem in (
        (["--json"], "--json needs --simulate or --compare"),
        (["--simulate", "--compare"], "not both"),
    ):
        assert main(["replay", str(file), *words]) == FAILED
        assert problem in capsys.readouterr().err


def test_a_file_that_is_none_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "text.mcap"
    file.write_text("no recording at all")
    assert main(["replay", str(file), "--simulate"]) == 2
    assert "is no MCAP file" in capsys.readouterr().err
