import subprocess
from pathlib import Path

import pytest

from tool0.installation.doctor.machine import Machine


def machine(root: Path, *programs: str, release: str = "") -> Machine:
    """Return a machine with these programs, which do nothing."""
    folder = root / "bin"
    folder.mkdir()
    for name in programs:
        (folder / name).write_text("#!/bin/sh\n")
        (folder / name).chmod(0o755)
    (root / "etc").mkdir()
    (root / "etc/os-release").write_text(release)
    return Machine(root=root, environ={"PATH": str(folder)}, system="linux")


def test_programs_are_sought_on_its_own_path(tmp_path: Path) -> None:
    here = machine(tmp_path, "second", "third")
    assert here.program("first", "third", "second") == str(tmp_path / "bin/third")
    assert here.program("sh") is None
    assert Machine(root=tmp_path, environ={}, system="linux").program("sh") is None


@pytest.mark.parametrize(
    ("manager", "command"),
    [
        ("apt-get", "sudo apt install g++"),
        ("dnf", "sudo dnf install gcc-c++"),
        ("pacman", "sudo pacman -S g++"),
        ("apk", ""),
        ("nothing", ""),
    ],
)
def test_each_installs_by_its_own_means(
    tmp_path: Path, manager: str, command: str
) -> None:
    here = machine(tmp_path, manager)
    assert here.install("g++", dnf="gcc-c++", apk="") == command


def test_the_release_is_read_as_it_is_written(tmp_path: Path) -> None:
    mint = '# Mint\nPRETTY_NAME="Linux Mint 21.3"\nID=\'linuxmint\'\n\nbroken\nODD="x\n'
    mint += "VERSION_CODENAME=virginia\nUBUNTU_CODENAME=jammy\n"
    here = machine(tmp_path, release=mint)
    assert (here.name(), here.codename()) == ("Linux Mint 21.3", "jammy")
    assert here.release()["ID"] == "linuxmint"
    assert here.release()["ODD"] == '"x'


def test_a_machine_without_a_release_has_a_name(tmp_path: Path) -> None:
    here = Machine(root=tmp_path, environ={}, system="linux")
    assert (here.name(), here.codename()) == ("Linux", "")


def test_a_program_that_hangs_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.installation.doctor.machine.PATIENCE", 0.2)
    with pytest.raises(subprocess.TimeoutExpired):
        Machine(root=tmp_path).ask(["/bin/sleep", "1000"])
