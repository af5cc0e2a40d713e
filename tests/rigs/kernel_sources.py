"""Copies of the kernel's sources, to compile and to break."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from promised import absent

from tool0.kernel.build import FOLDER, KernelBuildError, find_compiler


def copy_kernel(folder: Path) -> Path:
    """Copy sources and ``build.py`` into a new folder, and return that folder."""
    folder.mkdir()
    for path in FOLDER.iterdir():
        if path.suffix in (".c", ".h") or path.name == "build.py":
            shutil.copy(path, folder)
    return folder


def write_function(folder: Path, value: int) -> Path:
    """Write a folder with one C source whose function ``answer`` returns ``value``."""
    folder.mkdir(exist_ok=True)
    for name in ("export.h", "version.c"):
        shutil.copy(FOLDER / name, folder)
    (folder / "answer.c").write_text(
        '#include "export.h"\n'
        f"TOOL0_EXPORT int answer(void) {{ return {value}; }}\n"
        "int hidden(void) { return 0; }\n",
        encoding="ascii",
    )
    return folder


def without_compilers(monkeypatch: pytest.MonkeyPatch, *, path: Path) -> None:
    """Leave only the compilers of one folder."""
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(path))
    monkeypatch.setitem(sys.modules, "ziglang", None)


def require_compiler() -> list[str]:
    """Skip visibly, or fail if this run promised the kernel, without a compiler."""
    try:
        return find_compiler()
    except KernelBuildError as error:
        absent("kernel", str(error))
