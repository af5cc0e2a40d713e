from pathlib import Path

import pytest
from machine import add_gazebo_header, add_program

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.installation import (
    find_installation,
    include_folders,
    mark_complete,
    private_prefix,
)


@pytest.fixture(autouse=True)
def bare_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Hide what is installed; return the only folder of programs."""
    for name in (
        "TOOL0_GAZEBO",
        "GAZEBO_MODEL_PATH",
        "GAZEBO_PLUGIN_PATH",
        "LD_LIBRARY_PATH",
    ):
        monkeypatch.delenv(name, raising=False)
    programs = tmp_path / "usr" / "bin"
    programs.mkdir(parents=True)
    monkeypatch.setenv("PATH", str(programs))
    return programs


def add_server(folder: Path, version: str) -> Path:
    script = f"echo Gazebo multi-robot simulator, version {version}"
    return add_program(folder / "gzserver", script)


def add_headers(root: Path, version: str) -> None:
    add_gazebo_header(root, version)
    for name in ("sdformat-9.8", "ignition/math6", "ignition/msgs5"):
        (root / "include" / name).mkdir(parents=True)
    (root / "lib" / "x86_64-linux-gnu" / "gazebo-11" / "plugins").mkdir(parents=True)
    (root / "lib" / "x86_64-linux-gnu" / "OGRE-1.9.0").mkdir()


def add_prefix(prefix: Path, *, has_client: bool = True) -> None:
    add_headers(prefix / "usr", "11.1.0")
    triplet = "x86_64-linux-gnu"
    mark_complete(prefix, triplet=triplet, has_client=has_client, size=1)


def why_none() -> str:
    """Return why there is no Gazebo."""
    with pytest.raises(EngineUnavailableError) as error:
        find_installation()
    return str(error.value)


def test_the_system_s_comes_before_the_private_one(bare_machine: Path) -> None:
    server = add_server(bare_machine, "11.10.2")
    add_headers(bare_machine.parent, "11.10.2")
    add_prefix(private_prefix())
    found = find_installation()
    assert (found.version, found.prefix, found.server) == ("11.10.2", None, server)
    assert found.client is None
    share = bare_machine.parent / "share" / "gazebo-11"
    assert found.environment["GAZEBO_RESOURCE_PATH"] == str(share)
    assert "LD_LIBRARY_PATH" not in found.environment


def test_the_system_s_without_headers_says_which_package_has_them(
    bare_machine: Path,
) -> None:
    assert "tool0 gazebo install" in why_none()
    add_server(bare_machine, "11.10.2")
    assert "libgazebo-dev" in why_none()


def test_another_gazebo_is_not_taken(bare_machine: Path) -> None:
    add_server(bare_machine, "9.0.0")
    assert "9.0.0" in why_none()
    add_prefix(private_prefix())
    assert find_installation().version == "11.1.0"


def test_a_prefix_runs_from_where_it_is() -> None:
    prefix = private_prefix()
    add_prefix(prefix)
    found = find_installation()
    lib = prefix / "usr" / "lib" / "x86_64-linux-gnu"
    assert found.prefix == prefix
    assert found.server == prefix / "usr" / "bin" / "gzserver-11.1.0"
    assert found.client == prefix / "usr" / "bin" / "gzclient-11.1.0"
    assert found.environment["LD_LIBRARY_PATH"].split(":")[0] == str(lib)
    assert found.environment["OGRE_RESOURCE_PATH"] == str(lib / "OGRE-1.9.0")
    include = prefix / "usr" / "include"
    names = ("gazebo-11", "sdformat-9.8", "ignition/math6", "ignition/msgs5")
    assert set(found.include_dirs) == {include, *(include / name for name in names)}
    assert Path("/usr/include") not in include_folders(Path("/usr"))
    mark_complete(prefix, triplet="x86_64-linux-gnu", has_client=False, size=1)
    found = find_installation()
    assert found.client is None
    assert found.environment["DISPLAY"] == ""  # there is no driver to draw with
    (prefix / "tool0-gazebo.json").unlink()
    assert "tool0 gazebo install" in why_none()


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": 2}', "\xff"])
def test_a_marker_that_cannot_be_read_does_not_count(text: str) -> None:
    prefix = private_prefix()
    add_prefix(prefix)
    (prefix / "tool0-gazebo.json").write_bytes(text.encode("latin-1"))
    assert "tool0 gazebo install" in why_none()


def test_a_named_one_is_taken_alone(
    tmp_path: Path, bare_machine: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_server(bare_machine, "11.10.2")
    add_headers(bare_machine.parent, "11.10.2")
    add_prefix(tmp_path / "mine")
    monkeypatch.setenv("TOOL0_GAZEBO", str(tmp_path / "mine"))
    assert find_installation().prefix == tmp_path / "mine"
    monkeypatch.setenv("TOOL0_GAZEBO", str(bare_machine.parent))
    assert find_installation().version == "11.10.2"
    monkeypatch.setenv("TOOL0_GAZEBO", str(tmp_path))
    assert str(tmp_path) in why_none()


def test_a_person_s_own_paths_come_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GAZEBO_MODEL_PATH", "/my/models:")
    add_prefix(private_prefix())
    own, ours = find_installation().environment["GAZEBO_MODEL_PATH"].split(":")
    assert own == "/my/models"
    assert ours.endswith("share/gazebo-11/models")
