from pathlib import Path

import pytest
from machine import make_machine

from tool0.installation.machine import Machine


def test_programs_are_found_on_its_own_path(tmp_path: Path) -> None:
    examined = make_machine(tmp_path, "second", "third")
    assert examined.program("first", "third", "second") == str(tmp_path / "bin/third")
    assert examined.program("sh") is None
    assert Machine(root=tmp_path, environ={}).program("sh") is None


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
    mint = "# Mint\nPRETTY_NAME=\"Linux Mint 21.3\"\nID='linuxmint'\n\nbroken\n"
    mint += "VERSION_CODENAME=virginia\nUBUNTU_CODENAME=jammy\n"
    examined = make_machine(tmp_path, release=mint)
    assert (examined.name(), examined.codename()) == ("Linux Mint 21.3", "jammy")
    assert examined.release()["ID"] == "linuxmint"
    bare = Machine(root=tmp_path / "bare", system="linux")
    assert (bare.name(), bare.codename()) == ("Linux", "")
