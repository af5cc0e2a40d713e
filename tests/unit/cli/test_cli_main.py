import subprocess
import sys

import pytest

from tool0.cli import COMMANDS, FAILED, OK, main
from tool0.errors import ControlError

LOADED = """
import sys
from tool0.cli import main
assert main(sys.argv[1:]) == 0
heavy = {"tyro", "mujoco", "numpy", "yaml", "xacro", "logging"}
print(sorted(heavy & sys.modules.keys()), file=sys.stderr)
"""


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"], ["help"]])
def test_help_lists_every_command(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == OK
    text = capsys.readouterr().out
    for command, (_, summary) in COMMANDS.items():
        assert f"  {command} " in text
        assert summary in text


@pytest.mark.parametrize("arguments", ["--help", "--version"])
def test_help_imports_nothing_heavy(arguments: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED, arguments],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr.strip() == "[]"


def test_version_is_the_package_s(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == OK
    assert capsys.readouterr().out.startswith("tool0 0.")


def test_an_unknown_command_names_the_nearest(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["brinup"]) == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert error == "tool0: error: unknown command 'brinup'; did you mean 'bringup'?\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    assert end.value.code == OK
    assert f"usage: tool0 {command}" in capsys.readouterr().out


@pytest.mark.parametrize("command", COMMANDS)
def test_an_unknown_option_exits_with_2(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main([command, "--no-such-option", "1"])
    assert end.value.code == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert f"tool0 {command}" in error


def test_our_errors_are_one_line_and_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse() -> None:
        raise ControlError("no controller 'x' is loaded")

    monkeypatch.setattr("tool0.cli.sensors.state", refuse)
    assert main(["state"]) == FAILED
    assert capsys.readouterr().err == "tool0: error: no controller 'x' is loaded\n"


def test_a_reader_that_stops_reading_is_no_error() -> None:
    describe = [sys.executable, "-m", "tool0", "describe", "urdf"]
    program = subprocess.Popen(
        describe, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert program.stdout is not None
    assert program.stdout.readline().startswith("<?xml")
    program.stdout.close()
    assert program.stderr is not None
    assert program.stderr.read() == ""
    assert program.wait() == OK
    program.stderr.close()
