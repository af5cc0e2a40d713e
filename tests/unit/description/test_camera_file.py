"""``cameras:`` in a scene's file."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tool0.description.camera import Camera, looking
from tool0.description.scene_file import load_scene
from tool0.description.transform import Pose
from tool0.errors import ConfigError

FULL = """
cameras:
  - name: palm
    link: tool0
    pose: {xyz: [0, 0, 0.1], rpy: [0, 0, deg(90)]}
    width: 320
    height: 200
    field_of_view: deg(60)
    near: 0.02
    far: 3
  - {name: above, pose: {xyz: [0.5, 0, 1], look_at: [0.5, 0, 0], up: [1, 0, 0]}}
  - {name: side, pose: {xyz: [0, 2, 1], look_at: [0, 0, 0]}}
"""


def cameras_of(text: str, folder: Path) -> tuple[Camera, ...]:
    path = folder / "scene.yaml"
    path.write_text(text)
    return load_scene(path).cameras


def test_it_reads_every_key(tmp_path: Path) -> None:
    assert cameras_of(FULL, tmp_path) == (
        Camera(
            name="palm",
            link="tool0",
            pose=Pose(xyz=(0.0, 0.0, 0.1), rpy=(0.0, 0.0, math.pi / 2)),
            width=320,
            height=200,
            field_of_view=math.radians(60.0),
            near=0.02,
            far=3.0,
        ),
        Camera(
            name="above",
            pose=looking((0.5, 0.0, 1.0), (0.5, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ),
        Camera(name="side", pose=looking((0.0, 2.0, 1.0), (0.0, 0.0, 0.0))),
    )


HEAD = "cameras:\n- {name: first}\n"
BAD = {
    "no list": ("cameras: 3", 1, "'cameras' must be a list, got 3"),
    "no mapping": (HEAD + "- 3", 3, r"'cameras\[1\]' must be a mapping, got 3"),
    "no name": (HEAD + "- {width: 3}", 3, "lacks 'name'"),
    "a strange key": (HEAD + "- {name: a, fov: 1}", 3, "unknown key .*fov"),
    "twice": (HEAD + "- {name: first}", 3, "two cameras are called 'first', the other"),
    "half a pixel": (HEAD + "- {name: a,\n   width: 0.5}", 4, "whole number of pixels"),
    "no pixel": (HEAD + "- {name: a, width: 0}", 3, "must be 1 … 4096 pixels, got 0"),
    "turned twice": (
        HEAD + "- name: a\n  pose: {look_at: [0, 0, 0], rpy: [0, 0, 0]}",
        4,
        "unknown key .*rpy",
    ),
    "up without a direction": (HEAD + "- {name: a, pose: {up: [1, 0, 0]}}", 3, "up"),
    "nowhere to look": (
        HEAD + "- name: a\n  pose: {xyz: [0, 0, 1], look_at: [0, 0, 0]}",
        4,
        "choose another direction for up",
    ),
}


@pytest.mark.parametrize(("text", "line", "message"), BAD.values(), ids=BAD)
def test_what_is_wrong_is_told_with_file_and_line(
    text: str, line: int, message: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=message) as caught:
        cameras_of(text, tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / 'scene.yaml'}:{line}: ")
