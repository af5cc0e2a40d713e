"""``tool0 completion``: the scripts, and what bash makes of them."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tool0.cli import COMMANDS, OK, main
from tool0.cli.completion import table

BASH = shutil.which("bash")
SETTLE = 'COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _tool0; echo "${COMPREPLY[@]}"'


@pytest.fixture
def script(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    assert main(["completion", "bash"]) == OK
    path = tmp_path / "tool0"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    return path


@pytest.mark.skipif(BASH is None, reason="there is no bash")
@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("tool0 bri", "bringup"),
        ("tool0 --v", "--version"),
        ("tool0 controllers s", "start stop switch"),
        ("tool0 controllers list --js", "--json"),
        ("tool0 describe --arm ur5 t", "tree table"),
        ("tool0 bringup --no-r", "--no-realtime --no-remote"),
        ("tool0 log --severity w", "warning"),
        ("tool0 log --severity warning --no", "--no-requests"),
        ("tool0 program export --format p", "python"),
        ("tool0 completion ", "bash zsh"),
        ("tool0 check ", ""),
        ("tool0 bringup --scene ", ""),
        ("tool0 nothing ", ""),
    ],
)
def test_bash_completes(line: str, completed: str, script: Path) -> None:
    command = ["bash", "-c", f'source "$0"; {SETTLE}', str(script), *line.split(" ")]
    # No tool0 can be found: completion does not start it.
    done = subprocess.run(
        command,
        check=True,
        env={"PATH": "/nowhere"},
        executable=BASH,
        capture_output=True,
        text=True,
    )
    assert (done.stdout.strip(), done.stderr) == (completed, "")


def test_every_command_and_option_is_there() -> None:
    found = table()
    assert found[""][:-2] == list(COMMANDS)
    assert found["log"] == []
    assert {"--arm", "--realtime", "--no-realtime", "--help"} < {*found["bringup"]}
    assert found["bringup"] == found["bringup -"]
    assert found["log --severity"] == ["info", "warning", "error"]
    assert found["bringup --scene"] == []


def test_words_need_no_quotes() -> None:
    words = {word for words in table().values() for word in words}
    assert all(word.replace("-", "").isalnum() for word in words)


def test_the_script_of_zsh_can_be_a_file_in_fpath(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["completion", "zsh"]) == OK
    script = capsys.readouterr().out
    assert script.startswith("#compdef tool0\n")
    assert "compadd -a candidates" in script
    assert "'log --severity') echo 'info warning error' ;;" in script
