"""What `tool0 doctor` says about the kernel."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from kernel_sources import require_compiler, without_compilers, write_function
from machine import add_program

from tool0.cli.probes import kernel
from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import Machine
from tool0.kernel import library
from tool0.kernel.build import build
from tool0.kernel.library import COMPILE_COMMAND, VARIABLE


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a kernel that is not compiled."""
    require_compiler()
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(library, "FOLDER", tmp_path)
    return write_function(tmp_path, 1)


def probe(system: str = "linux") -> ProbeResult:
    (result,) = kernel(Machine(system=system))
    return result


def test_a_compiled_kernel_is_ready(folder: Path) -> None:
    path = build(folder)
    assert probe() == ProbeResult("kernel", "ready", f"compiled, {path}")


@pytest.mark.usefixtures("folder")
def test_a_missing_kernel_can_be_compiled() -> None:
    result = probe()
    assert (result.state, result.remedy) == ("missing", COMPILE_COMMAND)
    assert result.found.startswith("Python only, which is slower: ")
    assert result.found.endswith("does not exist")


def test_a_stale_kernel_can_be_compiled_again(folder: Path) -> None:
    build(folder)
    write_function(folder, 2)
    result = probe()
    assert (result.state, result.remedy) == ("missing", COMPILE_COMMAND)
    assert "compiled from other sources" in result.found


def test_without_a_compiler_one_is_installed(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_compilers(monkeypatch, path=folder)
    result = probe()
    assert result.found.endswith("; no C compiler")
    assert result.remedy == f"{COMPILE_COMMAND} --install-compiler"


def test_a_failing_compiler_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = add_program(folder / "bin/fake", "echo no licence; exit 1")
    monkeypatch.setenv("CC", str(fake))
    result = probe()
    assert f"`{fake}` fails: no licence" in result.found
    assert result.remedy == "unset CC"


def test_a_folder_of_somebody_else_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != folder)
    assert probe().found.endswith(f"'{folder}' is read-only for this account")


@pytest.mark.usefixtures("folder")
def test_the_selected_reference_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "python")
    assert probe().remedy == "unset TOOL0_KERNEL"


@pytest.mark.usefixtures("folder")
def test_windows_runs_the_reference() -> None:
    assert probe(system="win32").state == "not supported"
