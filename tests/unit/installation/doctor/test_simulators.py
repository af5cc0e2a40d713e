from pathlib import Path

import pytest

from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine
from tool0.installation.doctor.simulators import gazebo
from tool0.installation.gazebo.installation import NAMED_BY

CONFIG = '#define GAZEBO_VERSION_FULL "11.10.2"\n'


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Name a root that has no Gazebo, on a machine without a compiler."""
    monkeypatch.setenv(NAMED_BY, str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.delenv("CXX", raising=False)
    add(tmp_path, "bin/apt-get")
    return tmp_path


def add(root: Path, name: str, text: str = "#!/bin/sh\n") -> None:
    file = root / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    file.chmod(0o755)


def look() -> list[Line]:
    return gazebo(Machine(system="linux"))


def test_without_one_tool0_installs_it(root: Path) -> None:
    (line,) = look()
    assert (line.state, line.remedy) == ("missing", "tool0 gazebo install --gui")


def test_without_a_compiler_that_is_what_is_missing(root: Path) -> None:
    add(root, "include/gazebo-11/gazebo/gazebo_config.h", CONFIG)
    add(root, "bin/gzserver")
    (line,) = look()
    assert (line.state, line.remedy) == ("missing", "sudo apt install g++")


def test_a_system_s_gazebo_is_told_with_its_window(root: Path) -> None:
    add(root, "include/gazebo-11/gazebo/gazebo_config.h", CONFIG)
    add(root, "bin/gzserver")
    add(root, "bin/g++")
    engine, window = look()
    assert engine.state == "ready"
    assert engine.found.startswith("11.10.2, the system's, ")
    assert "compiled at the first start" in engine.found
    assert window.remedy == "tool0 gazebo install --gui --private"
    add(root, "bin/gzclient")
    engine, window = look()
    assert (window.state, window.found) == ("ready", str(root / "bin/gzclient"))


def test_elsewhere_than_on_linux_there_is_none() -> None:
    (line,) = gazebo(Machine(system="darwin"))
    assert line.state == "not supported"
