import contextlib
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from importlib import import_module

import pytest

import tool0
from tool0.cli import COMMANDS, FAILED, OK, main
from tool0.cli.options import READERS
from tool0.cli.parameters import parameters_of
from tool0.errors import ControlError

LOADED = """
import sys
from tool0.cli import main
assert main(sys.argv[1:]) == 0
heavy = {"mujoco", "numpy", "yaml", "xacro", "logging"}
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
    assert capsys.readouterr().out == f"tool0 {tool0.__version__}\n"


def test_an_unknown_command_names_the_nearest(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["brinup"]) == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert error == "tool0: error: unknown command 'brinup'; did you mean 'bringup'?\n"


def functions(command: str) -> Mapping[str, Callable[..., object]]:
    """Return the functions of a command and its subcommands by their words."""
    module, _ = COMMANDS[command]
    found = getattr(import_module(f"tool0.cli.{module}"), command)
    if callable(found):
        return {command: found}
    return {f"{command} {name}": function for name, function in found.items()}


FUNCTIONS = {
    words: function
    for command in COMMANDS
    for words, function in functions(command).items()
}
ARTEFACTS = (
    *("[bold]", "<class", "{None}", "None", "(default: )", "==SUPPRESS==", "``"),
    *("[dim]", "unset", "Args:", "True", "False", "function", "argument's"),
)
"""What a help text must not show: how it is made."""
FOREIGN = re.compile(
    r"for whoever|whoever|comes? along|does without|goes by|to be called|is told|"
    r"so many|where it is to be|what is felt|left out|A cheat"
)
"""Sentences that no engineer would say."""


@pytest.mark.parametrize("words", [*FUNCTIONS, *COMMANDS])
def test_a_help_text_is_clean(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main([*words.split(), "--help"])
    assert end.value.code == OK
    text = capsys.readouterr().out
    assert text.startswith(f"usage: tool0 {words}")
    assert [part for part in ARTEFACTS if part in text] == []
    assert not FOREIGN.search(" ".join(text.split()))


@pytest.mark.parametrize("words", FUNCTIONS)
def test_every_option_is_explained(words: str) -> None:
    for parameter in parameters_of(FUNCTIONS[words], READERS):
        assert re.match(r"[A-Za-z].*\w", parameter.help), parameter.path
        assert parameter.metavar.isascii(), parameter.path


def test_every_command_that_prints_data_prints_json() -> None:
    prints_none = (
        *("view", "export", "completion", "workspace", "pause", "resume", "reset"),
        *("estop", "program export", "ros1 env", "ros2 env"),
    )
    acts = ("load", "unload", "start", "stop", "switch", "save", "delete")
    acts += ("add", "remove", "place", "install", "uninstall")
    acts += ("enable", "disable", "play", "power-on", "power-off", "release-brakes")
    acts += ("unlock", "payload", "speed")
    flags = {
        words: {item.flag for item in parameters_of(function, READERS)}
        for words, function in FUNCTIONS.items()
    }
    assert [words for words in flags if "--json" not in flags[words]] == [
        words for words in flags if words in prints_none or words.split()[-1] in acts
    ]
    assert all("--format" not in flags[words] for words in ("check", "doctor"))


@pytest.mark.parametrize("words", [*FUNCTIONS, *COMMANDS, ""])
def test_every_command_that_a_help_text_names_exists(
    words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with contextlib.suppress(SystemExit):
        main([*words.split(), "--help"])
    text = " ".join(capsys.readouterr().out.split())
    named = re.findall(r"`tool0 ([^`]+)`", text)
    assert named or words in FUNCTIONS
    for line in named:
        command, *rest = line.split()
        if command == "COMMAND":
            continue
        assert command in COMMANDS
        if command not in FUNCTIONS and rest[0] not in ("SUBCOMMAND", "--help"):
            assert f"{command} {rest[0]}" in FUNCTIONS


@pytest.mark.parametrize("words", FUNCTIONS)
def test_an_unknown_option_is_one_line_and_2(
    words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words.split(), "--qqq", "1"]) == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert error == (f"tool0: error: no option --qqq; see `tool0 {words} --help`\n")


def test_an_unknown_subcommand_names_the_nearest(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["controllers", "lst"]) == FAILED
    assert "no subcommand 'lst'; did you mean 'list'?" in capsys.readouterr().err


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
