"""Checks of files without a process for each."""

from __future__ import annotations

import pytest

from tool0.lint import check


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let work be done here: a fork of this large process, for each file, takes long."""
    monkeypatch.setattr(check, "run_limited", lambda work, *a, **k: work(*a, **k))
