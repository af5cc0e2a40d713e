"""Where the dashboard server's programs are, if nobody says."""

from pathlib import Path

import pytest

from tool0.cli.options import UrControllerOptions


def test_programs_are_in_the_users_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    saved = tmp_path / "tool0" / "ur-programs"
    assert UrControllerOptions().options().programs == saved
    assert saved.is_dir()
    chosen = UrControllerOptions(ur_programs=tmp_path)
    assert chosen.options().programs == tmp_path
