from pathlib import Path

import pytest
from machine import make_machine

from tool0.cli import probes
from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import Machine


def browser(examined: Machine) -> ProbeResult:
    (result,) = probes.browser(examined)
    return result


def test_a_browser_opens_where_there_is_a_desktop(tmp_path: Path) -> None:
    assert "http://127.0.0.1:8085/" in browser(make_machine(tmp_path, "firefox")).found
    examined = make_machine(tmp_path, WAYLAND_DISPLAY="wayland-0")
    assert browser(examined).state == "ready"
    assert "http" not in browser(examined).found


@pytest.mark.parametrize(
    ("manager", "release", "remedy"),
    [
        ("apt-get", "ID=debian\n", "sudo apt install firefox-esr"),
        ("apt-get", "ID=ubuntu\n", "sudo apt install firefox"),
        ("dnf", "ID=fedora\n", "sudo dnf install firefox"),
        ("zypper", "ID=opensuse\n", "sudo zypper install MozillaFirefox"),
    ],
)
def test_a_browser_is_installed_by_its_name_there(
    tmp_path: Path, manager: str, release: str, remedy: str
) -> None:
    result = browser(make_machine(tmp_path, manager, release=release))
    assert (result.state, result.remedy) == ("missing", remedy)
    assert "--panel-host 0.0.0.0" in result.found


@pytest.mark.parametrize(
    ("system", "name"), [("darwin", "Safari"), ("win32", "Microsoft Edge")]
)
def test_some_systems_have_a_browser(tmp_path: Path, system: str, name: str) -> None:
    result = browser(make_machine(tmp_path, system=system))
    assert result.state == "ready"
    assert result.found.startswith(name)
