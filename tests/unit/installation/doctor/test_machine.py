import subprocess
from pathlib import Path

import pytest
from machine import make_machine

from tool0.installation.doctor.machine import ExaminedMachine


def test_programs_are_found_on_its_own_path(tmp_path: Path) -> None:
    examined = make_machine(tmp_path, "second", "third")
    assert examined.program("first", "third", "second") == str(tmp_path / "bin/third")
    assert examined.program("sh") is None
    assert ExaminedMachine(root=tmp_path, environ={}).program("sh") is None


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
def test_each_package_manager_has_its_command(
    tmp_path: Path, manager: str, command: str
) -> None:
    examined = make_machine(tmp_path, manager)
    assert examined.install_command("g++", dnf="gcc-c++", apk="") == command


def test_the_release_is_parsed_as_shell_assignments(tmp_path: Path) -> None:
    mint = '# Mint\nPRETTY_NAME="Linux Mint 21.3"\nID=\'linuxmint\'\n\nbroken\nODD="x\n'
    mint += "VERSION_CODENAME=virginia\nUBUNTU_CODENAME=jammy\n"
    examined = make_machine(tmp_path, release=mint)
    assert (examined.name(), examined.codename()) == ("Linux Mint 21.3", "jammy")
    assert examined.release()["ID"] == "linuxmint"
    assert examined.release()["ODD"] == '"x'


def test_a_machine_without_a_release_has_a_name(tmp_path: Path) -> None:
    examined = ExaminedMachine(root=tmp_path, environ={}, system="linux")
    assert (examined.name(), examined.codename()) == ("Linux", "")


def test_a_program_that_hangs_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.installation.doctor.machine.PROGRAM_TIMEOUT", 0.2)
    with pytest.raises(subprocess.TimeoutExpired):
        ExaminedMachine(root=tmp_path).output_of(["/bin/sleep", "1000"])
