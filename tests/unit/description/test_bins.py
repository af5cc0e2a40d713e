"""What a bin is made of."""

from __future__ import annotations

import itertools
import math

import pytest

from tool0.description.scene import SceneObject, bin_walls
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ConfigError

SIZE = (0.3, 0.2, 0.1)
WALL = 0.004


def interval(item: SceneObject, axis: int) -> tuple[float, float]:
    """Return from where to where a part that is not turned reaches [m]."""
    assert isinstance(item.geometry, Box)
    centre, half = item.pose.xyz[axis], item.geometry.size[axis] / 2
    return centre - half, centre + half


def test_its_parts_fill_its_size_without_overlap() -> None:
    parts = bin_walls("bin", size=SIZE, wall=WALL)
    for axis in range(3):
        ends = [end for item in parts for end in interval(item, axis)]
        assert min(ends) == pytest.approx(-SIZE[axis] / 2)
        assert max(ends) == pytest.approx(SIZE[axis] / 2)
    for one, two in itertools.combinations(parts, 2):
        overlaps = [
            min(interval(one, axis)[1], interval(two, axis)[1])
            - max(interval(one, axis)[0], interval(two, axis)[0])
            for axis in range(3)
        ]
        assert min(overlaps) < 1e-12
    inside = (SIZE[0] - 2 * WALL) * (SIZE[1] - 2 * WALL) * (SIZE[2] - WALL)
    volume = sum(math.prod(i.geometry.size) for i in parts if type(i.geometry) is Box)
    assert volume == pytest.approx(math.prod(SIZE) - inside)


def test_it_is_turned_as_a_whole() -> None:
    pose = Pose(xyz=(1.0, 2.0, 3.0), rpy=(0.0, 0.0, math.pi / 2))
    parts = {i.name: i for i in bin_walls("b", size=SIZE, wall=WALL, pose=pose)}
    front = parts["b.front"].pose
    assert front.rpy == pose.rpy
    assert front.xyz == pytest.approx((1.0, 2.0 + (0.3 - WALL) / 2, 3.0 + WALL / 2))
    assert all(item.mass is None for item in parts.values())


@pytest.mark.parametrize("wall", [0.0, -0.01, 0.1, math.nan, math.inf])
def test_its_walls_leave_room_inside(wall: float) -> None:
    with pytest.raises(ConfigError, match="walls of bin 'b'"):
        bin_walls("b", size=SIZE, wall=wall)
