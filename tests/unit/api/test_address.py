import os
import subprocess
import sys
from pathlib import Path

import pytest
from raises_naming import raises_naming
from served import use_folder

from tool0.api.address import Claim, folders, running_names, socket_path
from tool0.errors import TransportError

HOLDER = """
import sys
from tool0.api.address import Claim
claim = Claim("taken")
claim.path.touch()
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


def held_by_another_process() -> "subprocess.Popen[str]":
    other = subprocess.Popen(
        [sys.executable, "-c", HOLDER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert other.stdout is not None
    assert other.stdout.readline() == "held\n"
    return other


def test_a_name_is_held_once_and_free_again_after_close(folder: Path) -> None:
    claim, other = Claim("left"), Claim("right")
    assert claim.path != other.path
    assert folder.stat().st_mode & 0o777 == 0o700
    with raises_naming(TransportError, "'left'", f"pid {os.getpid()}"):
        Claim("left")
    other.close()
    claim.close()
    claim.close()
    Claim("left").close()
    assert list(folder.iterdir()) == []


def test_a_live_process_keeps_its_name_and_a_dead_one_loses_it(folder: Path) -> None:
    other = held_by_another_process()
    with raises_naming(TransportError, f"pid {other.pid}", "--name"):
        Claim("taken")
    assert (folder / "taken.sock").exists()
    other.kill()
    other.communicate()
    assert (folder / "taken.sock").exists()
    claim = Claim("taken")
    assert not claim.path.exists()
    claim.close()


def test_without_a_runtime_folder_a_private_temporary_one_serves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "missing"))
    claim = Claim("left")
    assert claim.path.parent == folders()[-1] == tmp_path / f"tool0-{os.getuid()}"
    assert claim.path.parent.stat().st_mode & 0o777 == 0o700
    claim.close()


@pytest.mark.parametrize("is_link", [False, True])
def test_a_folder_that_others_can_enter_or_choose_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_link: bool
) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    shared = tmp_path / f"tool0-{os.getuid()}"
    if is_link:
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        shared.symlink_to(tmp_path / "elsewhere")
    else:
        shared.mkdir()
        shared.chmod(0o755)
    with pytest.raises(TransportError):
        Claim("left")


@pytest.mark.parametrize("name", ["", "../x", "a/b", ".hidden", "x" * 65, "a\nb", "ä"])
def test_a_bad_name_and_a_path_too_long_are_refused(name: str, folder: Path) -> None:
    with pytest.raises(TransportError):
        socket_path(folder, name)
    with raises_naming(TransportError, "103"):
        socket_path(folder / ("x" * 100), "left")


def test_running_names_are_those_with_a_socket(folder: Path) -> None:
    assert running_names() == ()
    claim = Claim("left")
    claim.path.touch()
    assert running_names() == ("left",)
    claim.close()
