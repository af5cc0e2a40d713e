"""How the compiled kernel is found, and what happens if it cannot be used."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
from kernel_sources import require_compiler, write_function

import tool0
from tool0.errors import ConfigError
from tool0.kernel import library
from tool0.kernel.build import LIBRARY, build, source_digest
from tool0.kernel.library import COMPILE_COMMAND, VARIABLE, kernel_status, load

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a kernel that is compiled."""
    require_compiler()
    build(write_function(tmp_path, 42))
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(library, "FOLDER", tmp_path)
    return tmp_path


def reason_to_run_python(caplog: pytest.LogCaptureFixture) -> str:
    """Return why there is no compiled kernel, which is warned of once."""
    with caplog.at_level(logging.INFO, logger="tool0.kernel"):
        assert load() is None
        status = kernel_status()
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert status.reason in record.message
    assert record.message.endswith(COMPILE_COMMAND)
    assert status.library is None
    return status.reason


def test_a_compiled_kernel_is_loaded_once(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    found = load()
    assert found is not None
    assert found.answer() == 42
    assert load() is found
    assert kernel_status().path == folder / LIBRARY
    assert not caplog.records


@pytest.mark.usefixtures("folder")
def test_the_python_reference_can_be_selected(monkeypatch: pytest.MonkeyPatch) -> None:
    assert load() is not None
    monkeypatch.setenv(VARIABLE, "python")
    assert load() is None
    assert kernel_status().reason.startswith("TOOL0_KERNEL=python selects")
    monkeypatch.setenv(VARIABLE, "")
    assert load() is not None


@pytest.mark.usefixtures("folder")
def test_an_unknown_selection_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "pyton")
    with pytest.raises(ConfigError, match="TOOL0_KERNEL='pyton'; valid: python"):
        load()


def test_a_kernel_that_was_never_compiled_is_no_warning(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / LIBRARY).unlink()
    with caplog.at_level(logging.INFO, logger="tool0.kernel"):
        assert load() is None
    assert [record.levelno for record in caplog.records] == [logging.INFO]
    assert "does not exist" in kernel_status().reason


def test_a_stale_kernel_is_not_used(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_function(folder, 43)
    assert "compiled from other sources" in reason_to_run_python(caplog)


def test_a_file_that_is_no_library_is_not_used(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / LIBRARY).write_text(f"garbage of {source_digest(folder)}")
    assert "cannot load" in reason_to_run_python(caplog)


def test_a_library_of_another_processor_is_not_used(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    content = bytearray((folder / LIBRARY).read_bytes())
    assert content[:4] == b"\x7fELF"
    content[18] = 8 if content[18] != 8 else 62  # MIPS, x86-64: see elf.h
    (folder / LIBRARY).write_bytes(content)
    assert "cannot load" in reason_to_run_python(caplog)


def test_what_cannot_be_read_is_not_used(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / LIBRARY).unlink()
    (folder / LIBRARY).mkdir()
    assert "cannot read" in reason_to_run_python(caplog)


def test_a_bringup_runs_without_a_usable_kernel(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_function(folder, 43)
    with tool0.bringup(realtime=False) as robot:
        robot.run(0.02)
        assert robot.time == 0.02
    assert "compiled from other sources" in reason_to_run_python(caplog)
