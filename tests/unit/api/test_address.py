import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from raises_naming import raises_naming
from served import use_folder

import tool0
from tool0.errors import TransportError
from tool0.protocol.address import Claim, folders, running_names, socket_path

HOLDER = """
import sys
from tool0.protocol.address import Claim
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


IMPOSTOR = """
import os, socket, sys
listener = socket.socket(socket.AF_UNIX)
listener.bind(sys.argv[1])
os.setuid(int(sys.argv[2]))
listener.listen()
print("listening", flush=True)
while True:
    peer, _ = listener.accept()
    peer.sendall(b"hello\\n")
"""
OTHER_USER = 12345
needs_root = pytest.mark.skipif(os.getuid() != 0, reason="only root has other users")


@contextmanager
def impostor(path: Path, user: int) -> Iterator[None]:
    """Run a program of ``user`` that listens at ``path``."""
    command = [sys.executable, "-c", IMPOSTOR, str(path), str(user)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "listening\n"
        yield
        program.kill()


@pytest.mark.parametrize(
    "trap", ["link", "mode", pytest.param("owner", marks=needs_root)]
)
def test_a_client_trusts_no_folder_that_others_can_enter_or_choose(
    trap: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    shared = tmp_path / f"tool0-{os.getuid()}"
    real = tmp_path / "elsewhere" if trap == "link" else shared
    real.mkdir(mode=0o700)
    with impostor(real / "tool0.sock", os.getuid()):
        if trap == "link":
            shared.symlink_to(real)
        elif trap == "mode":
            shared.chmod(0o755)
        else:
            os.chown(shared, OTHER_USER, -1)
        with raises_naming(TransportError, "another user", str(shared)):
            tool0.connect()
        assert running_names() == ()


@needs_root
def test_a_client_trusts_no_socket_that_another_user_serves(folder: Path) -> None:
    folder.mkdir(mode=0o700)
    with (
        impostor(folder / "tool0.sock", OTHER_USER),
        raises_naming(TransportError, "another user", "tool0.sock"),
    ):
        tool0.connect()


def test_a_folder_in_place_of_a_file_is_named(folder: Path) -> None:
    for name in ("left.lock", "left.sock"):
        path = folder / name
        path.mkdir(parents=True)
        folder.chmod(0o700)
        with raises_naming(TransportError, str(path)):
            Claim("left")
        path.rmdir()
    Claim("left").close()


def test_running_names_are_those_with_a_socket(folder: Path) -> None:
    assert running_names() == ()
    claim = Claim("left")
    claim.path.touch()
    assert running_names() == ("left",)
    claim.close()
