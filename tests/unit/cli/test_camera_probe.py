from pathlib import Path

import pytest
from machine import make_machine
from promised import require_gl

from tool0.cli.probes import cameras


def test_whether_cameras_draw_is_tried(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    examined = make_machine(tmp_path, "apt-get")
    monkeypatch.setenv("MUJOCO_GL", "disable")
    (result,) = cameras(examined)
    assert result.state == "missing"
    assert "MUJOCO_GL is 'disable'" in result.found
    assert result.remedy == "sudo apt install libegl1 libopengl0 libgl1-mesa-dri"
    monkeypatch.delenv("MUJOCO_GL")
    require_gl()
    (result,) = cameras(examined)
    assert result.state == "ready"
