"""Which files of the package are definitions of messages."""

from __future__ import annotations

import compileall
import shutil
from pathlib import Path

import pytest

from tool0.installation.ros1 import messages


def test_compiled_modules_are_no_definitions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Installing a wheel compiles the Python modules beside the definitions."""
    copy = tmp_path / "definitions"
    shutil.copytree(messages.DEFINITIONS, copy)
    expected = {
        name: [file.name for file in messages.definition_files(name)]
        for name in messages.package_names()
    }
    assert expected["control_msgs"]
    assert compileall.compile_dir(copy, quiet=1)
    (copy / "__pycache__").mkdir()
    monkeypatch.setattr(messages, "DEFINITIONS", copy)
    assert any(copy.rglob("*.pyc"))
    assert {
        name: [file.name for file in messages.definition_files(name)]
        for name in messages.package_names()
    } == expected
