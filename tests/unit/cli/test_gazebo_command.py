import io
import json
from pathlib import Path

import pytest
from machine import add_gazebo_header, add_program

from tool0.cli import FAILED, OK, main
from tool0.cli.text import ProgressBar
from tool0.installation.gazebo.installation import mark_complete, private_prefix


@pytest.fixture(autouse=True)
def bare_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Hide what is installed, but for something that passes for a compiler."""
    script = 'for last; do :; done; echo made > "$last"'
    compiler = add_program(tmp_path / "bin" / "g++", script)
    monkeypatch.setenv("PATH", f"{compiler.parent}:/bin")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setenv("TOOL0_GAZEBO", str(private_prefix()))


def add_prefix(*, has_client: bool) -> None:
    add_gazebo_header(private_prefix() / "usr", "11.1.0")
    mark_complete(
        private_prefix(),
        triplet="x86_64-linux-gnu",
        has_client=has_client,
        size=123_456_789,
    )


def status(capsys: pytest.CaptureFixture[str]) -> tuple[int, dict[str, object]]:
    capsys.readouterr()
    code = main(["gazebo", "status", "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_status_without_any_fails(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = status(capsys)
    assert code == 1
    assert found["can_run"] is False
    assert found["version"] is None
    assert "tool0 gazebo install" in str(found["missing"])


def test_status_tells_what_would_run(capsys: pytest.CaptureFixture[str]) -> None:
    add_prefix(has_client=False)
    code, found = status(capsys)
    assert code == OK
    assert found["can_run"] is True
    assert (found["version"], found["size"]) == ("11.1.0", 123_456_789)
    assert (found["client"], found["is_compiled"]) == (None, False)
    assert found["missing"] == ["a window: tool0 gazebo install --gui"]
    assert main(["gazebo", "status"]) == OK
    text = capsys.readouterr().out
    assert "11.1.0, private, 123 MB" in text


def test_without_a_compiler_only_what_is_compiled_runs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    add_prefix(has_client=True)
    monkeypatch.setenv("CXX", "no-such-compiler")
    code, found = status(capsys)
    assert (code, found["can_run"]) == (1, False)
    assert found["missing"] == ["a C++ compiler: apt install g++"]
    monkeypatch.delenv("CXX")
    assert main(["gazebo", "install", "--private"]) == OK  # it is there: only compiles
    monkeypatch.setenv("CXX", "no-such-compiler")
    code, found = status(capsys)
    assert (code, found["is_compiled"], found["missing"]) == (OK, True, [])


def test_installing_says_what_is_ready(capsys: pytest.CaptureFixture[str]) -> None:
    add_prefix(has_client=True)
    assert main(["gazebo", "install", "--private", "--gui"]) == OK
    said = capsys.readouterr()
    assert said.out == f"ready: Gazebo 11.1.0 in {private_prefix()}\n"
    assert said.err == "compiling the bridge to Gazebo\n"


def test_a_wrong_mirror_is_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["gazebo", "install", "--private", "--mirror", "nowhere"]) == FAILED
    assert "nowhere" in capsys.readouterr().err


def test_uninstalling_twice_is_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    add_prefix(has_client=True)
    assert main(["gazebo", "uninstall"]) == OK
    assert not private_prefix().exists()
    assert "removed" in capsys.readouterr().out
    assert main(["gazebo", "uninstall"]) == OK
    assert capsys.readouterr().out == "nothing to remove\n"


def test_without_a_terminal_an_activity_is_a_line() -> None:
    stream = io.StringIO()
    with ProgressBar(stream) as progress:
        for fraction in (0.0, 0.5, 1.0):
            progress("downloading", fraction)
        progress("unpacking", 0.0)
    assert stream.getvalue() == "downloading\nunpacking\n"


def test_on_a_terminal_a_bar_is_drawn_over_itself() -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    stream = Terminal()
    with ProgressBar(stream) as progress:
        progress("downloading", 0.0)
        progress("downloading", 0.5)
        progress("downloading", 0.5)
        progress("unpacking", 1.5)
    first, second, rest = stream.getvalue().split("\n")
    assert first.count("\r") == 2
    assert first.endswith("############............  50 %  downloading")
    assert second.endswith("100 %  unpacking")
    assert rest == ""
