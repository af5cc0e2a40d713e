"""The UR interface on a machine without the package that reads URScript."""

from __future__ import annotations

import importlib.util

import pytest
from fresh_python import run

HIDE = "import sys; sys.modules['lark'] = None\n"  # its import fails


def test_the_interface_prepares_without_urscript() -> None:
    program = "from tool0.ur.compiling import prepare\nprepare()\n"
    assert run(f"{HIDE}{program}print('ready')") == "ready\n"


def test_the_greeting_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    from tool0.cli.text import ur_lines
    from tool0.ur.options import UrArm

    arms = {"arm": UrArm(address="127.0.0.1")}
    assert ur_lines(arms)[0].endswith("dashboard server, URScript")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert "no URScript, which needs the package lark" in ur_lines(arms)[0]
