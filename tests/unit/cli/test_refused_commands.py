"""A command that the robot does not offer fails with the reason, in one line."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from lacking import Lacking

import tool0
from tool0.cli import FAILED, main
from tool0.protocol.address import Claim
from tool0.protocol.channel import backend_of
from tool0.protocol.objects import AddObject, RemoveObject
from tool0.protocol.programs import CheckProgram, RunProgram
from tool0.protocol.recordings import StartRecording
from tool0.protocol.running import Reset
from tool0.server.server import Server, UnixSocketService

PROGRAM = "name: wait\nsteps: [{kind: wait, duration: 0.1}]\n"
REASON = "this robot only follows joint paths"
LACKS = (AddObject, RemoveObject, CheckProgram, RunProgram, StartRecording, Reset)


@pytest.fixture(scope="module", autouse=True)
def served(runtime_folder: Path) -> Iterator[None]:
    with tool0.bringup(gripper=None, realtime=False) as robot:
        backend = Lacking(backend_of(robot.channel), LACKS, REASON)
        with Server(backend, [UnixSocketService(Claim("tool0"))], "tool0"):
            yield


@pytest.mark.parametrize(
    ("command", "method"),
    [
        ("reset", "reset"),
        ("scene add cube --box 0.1 0.1 0.1 --xyz 0.5 0 0.1", "add_object"),
        ("scene remove cube", "remove_object"),
        ("record session.mcap", "start_recording"),
        ("run program.yaml", "run_program"),
        ("run program.yaml --check", "check_program"),
    ],
)
def test_the_reason_is_one_line(
    command: str,
    method: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "program.yaml").write_text(PROGRAM)
    assert main(command.split()) == FAILED
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err == f"tool0: error: '{method}' is not offered: {REASON}\n"
