"""Checks of files, without a process for each file."""

from __future__ import annotations

import pytest

from tool0.lint import check


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read files here: to fork this large process for each of them takes long."""
    monkeypatch.setattr(check, "run_limited", lambda work, *a, **k: work(*a, **k))
