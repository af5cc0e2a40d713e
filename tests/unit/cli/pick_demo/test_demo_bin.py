"""The bin of the demo, and what is in it."""

from __future__ import annotations

import pytest

from tool0.cli.pick_demo.grasps import find_bin
from tool0.description.scene_file import load_scene
from tool0.description.transform import Pose, Transform
from tool0.errors import ControlError
from tool0.scene import bin_walls

SIZE = (0.3, 0.2, 0.1)
WALLS = bin_walls("crate", size=SIZE, pose=Pose(xyz=(0.5, -0.3, 0.05)))


def test_its_corners_are_those_of_its_walls() -> None:
    found = find_bin(WALLS, "crate")
    assert found.lower == pytest.approx((0.35, -0.4, 0.0))
    assert found.upper == pytest.approx((0.65, -0.2, 0.1))
    assert found.center == pytest.approx((0.5, -0.3, 0.0))


@pytest.mark.parametrize(
    ("position", "is_in"),
    [
        ((0.5, -0.3, 0.02), True),
        ((0.5, -0.3, 0.12), False),  # still above
        ((0.5, -0.19, 0.02), False),
        ((0.66, -0.3, 0.02), False),
        ((0.5, -0.3, -0.02), False),  # under it
    ],
)
def test_what_is_in_it(position: tuple[float, float, float], is_in: bool) -> None:
    assert find_bin(WALLS, "crate").holds(Transform(position=position)) is is_in


def test_a_scene_without_one() -> None:
    with pytest.raises(ControlError, match="no bin 'crates'"):
        find_bin(WALLS, "crates")
    assert find_bin(load_scene("table_and_bin").objects, "bin").center[1] < 0.0
