"""Pairs of links of an SRDF that planned motions need not keep apart."""

from __future__ import annotations

from pathlib import Path

import pytest

import tool0
from tool0.description.loading import assemble
from tool0.description.srdf import read_disabled_collisions

SRDF = """<?xml version="1.0"?>
<robot name="ur5">
  <group name="manipulator"><chain base_link="base_link" tip_link="tool0"/></group>
  <disable_collisions link1="{0}" link2="forearm_link" reason="Never"/>
</robot>
"""


def srdf(folder: Path, link: str) -> Path:
    file = folder / "robot.srdf"
    file.write_text(SRDF.format(link), encoding="utf-8")
    return file


def test_the_pairs_of_a_file(tmp_path: Path) -> None:
    model = assemble("ur5", None).model
    found = read_disabled_collisions(srdf(tmp_path, "base_link_inertia"), model)
    assert found == {frozenset(("base_link_inertia", "forearm_link"))}


def test_an_unknown_link_is_named_with_its_line(tmp_path: Path) -> None:
    file = srdf(tmp_path, "wrist_4_link")
    with pytest.raises(tool0.DescriptionError, match=r"wrist_4_link") as caught:
        tool0.bringup(description=tool0.DescriptionConfig(srdf=file))
    location = caught.value.location
    assert location is not None
    assert (location.file, location.line) == (file, 4)


def test_a_motion_may_bring_its_pairs_together(tmp_path: Path) -> None:
    folded = {"shoulder_lift_joint": -1.8, "elbow_joint": 2.75, "wrist_1_joint": 2.2}
    target = {**folded, "wrist_2_joint": 0.0}
    with tool0.bringup(realtime=False) as robot:
        blocked = robot.arm.check(target)
    assert "forearm_link" in blocked.reason
    assert "wrist_2_link" in blocked.reason
    description = tool0.DescriptionConfig(srdf=srdf(tmp_path, "wrist_2_link"))
    with tool0.bringup(description=description, realtime=False) as robot:
        assert robot.arm.check(target).is_free
