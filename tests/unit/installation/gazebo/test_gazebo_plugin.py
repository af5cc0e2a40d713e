from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from shutil import copytree

import pytest
from machine import add_program

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo import plugin
from tool0.installation.gazebo.installation import GazeboInstallation
from tool0.installation.gazebo.plugin import (
    bridge_libraries,
    expected_libraries,
    plugin_folder,
)

INSTALLATION = GazeboInstallation(
    version="11.1.0",
    prefix=None,
    server=Path("/usr/bin/gzserver"),
    client=None,
    environment={},
    include_dirs=(Path("/somewhere/include"),),
)
COMPILER = """\
echo "$*" >> "{calls}"
{fail}
for last; do :; done
sleep 0.05
echo made > "$last"
"""


@pytest.fixture
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in for the compiler; return where it notes how it was called."""
    file = tmp_path / "calls"
    set_compiler(tmp_path, monkeypatch, COMPILER.format(calls=file, fail=""))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return file


def set_compiler(folder: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv("CXX", str(add_program(folder / "g++", text)))


def test_compiles_each_once(calls: Path) -> None:
    libraries = bridge_libraries(INSTALLATION)
    assert libraries.bridge.read_text() == libraries.preload.read_text() == "made\n"
    assert bridge_libraries(INSTALLATION) == libraries
    assert len(calls.read_text().splitlines()) == 2
    assert "-isystem/somewhere/include" in calls.read_text()
    others = bridge_libraries(replace(INSTALLATION, version="11.10.2"))
    assert others.bridge != libraries.bridge


def test_a_change_of_any_source_of_the_bridge_makes_another_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = copytree(Path(plugin.__file__).parent / "bridge", tmp_path / "bridge")
    sources = folder / "bridge.cc", folder / "preload.cc"
    monkeypatch.setattr(plugin, "_SOURCES", sources)
    before = expected_libraries(INSTALLATION)
    headers = sorted(folder.glob("*.h"))
    assert headers
    for file in (sources[0], *headers):
        text = file.read_text(encoding="utf-8")
        file.write_text(text + "// changed\n", encoding="utf-8")
        changed = expected_libraries(INSTALLATION)
        file.write_text(text, encoding="utf-8")
        assert changed.bridge != before.bridge, file.name
        assert changed.preload == before.preload, file.name
    assert expected_libraries(INSTALLATION) == before


def test_what_was_compiled_outlives_the_compiler(
    calls: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    libraries = bridge_libraries(INSTALLATION)
    monkeypatch.setenv("CXX", "no-such-compiler")
    assert bridge_libraries(INSTALLATION) == libraries
    libraries.preload.unlink()
    with pytest.raises(EngineUnavailableError) as error:
        bridge_libraries(INSTALLATION)
    assert "apt install g++" in str(error.value)


def test_several_may_compile_at_once(calls: Path) -> None:
    with ThreadPoolExecutor(4) as pool:
        made = list(pool.map(bridge_libraries, [INSTALLATION] * 4))
    assert len(set(made)) == 1
    assert {path.name for path in plugin_folder().iterdir()} == {
        made[0].bridge.name,
        made[0].preload.name,
    }


def test_what_the_compiler_said_is_shown_and_nothing_is_kept(
    calls: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail = "echo 'bridge.cc:1: error: no such header' >&2; exit 1"
    set_compiler(tmp_path, monkeypatch, COMPILER.format(calls=calls, fail=fail))
    with pytest.raises(EngineUnavailableError) as error:
        bridge_libraries(INSTALLATION)
    assert "error: no such header" in str(error.value)
    assert not list(plugin_folder().iterdir())


def test_a_folder_that_cannot_be_written_is_named(calls: Path, tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("in the way")
    with pytest.raises(EngineUnavailableError) as error:
        bridge_libraries(INSTALLATION)
    assert str(tmp_path / "cache") in str(error.value)
