"""Where objects can be grasped from above, and the bin that they go into."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tool0.api.grasps import find_bin, find_grasps, finger_reach, half_height
from tool0.description.loading import assemble
from tool0.description.scene import SceneObject, bin_walls
from tool0.description.scene_file import load_scene
from tool0.description.shapes import Box, Compound, Cylinder, Mesh, Solid, Sphere
from tool0.description.transform import Pose, Transform, to_transform
from tool0.errors import ControlError

LARGEST = 0.085


def thing(geometry: Solid, **pose: tuple[float, float, float]) -> SceneObject:
    return SceneObject(name="thing", geometry=geometry, pose=Pose(**pose), mass=0.1)


def grasps(item: SceneObject) -> list[tuple[Transform, float]]:
    found = find_grasps(item, to_transform(item.pose), LARGEST)
    return [(grasp.pose, grasp.width) for grasp in found]


def test_a_box_is_taken_across_each_side_that_fits_either_way_round() -> None:
    yaw = 0.3
    item = thing(Box(size=(0.04, 0.06, 0.1)), xyz=(0.5, 0.1, 0.2), rpy=(0.0, 0.0, yaw))
    found = grasps(item)
    assert sorted(width for _, width in found) == [0.04, 0.04, 0.06, 0.06]
    for pose, width in found:
        matrix = pose.matrix
        np.testing.assert_allclose(matrix[:3, 2], (0.0, 0.0, -1.0), atol=1e-12)
        assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1.0)
        np.testing.assert_allclose(matrix[:3, 3], (0.5, 0.1, 0.2))
        across = (math.cos(yaw), math.sin(yaw), 0.0)  # the box's x, 4 cm wide
        if width == 0.06:
            across = (-across[1], across[0], 0.0)
        assert abs(matrix[:3, 1] @ across) == pytest.approx(1.0)


def test_a_side_that_is_too_wide_is_left_out() -> None:
    assert {width for _, width in grasps(thing(Box(size=(0.04, 0.2, 0.1))))} == {0.04}


def test_a_box_on_another_side_is_taken_as_it_lies() -> None:
    item = thing(Box(size=(0.03, 0.05, 0.2)), rpy=(0.0, math.pi / 2.0, 0.0))
    assert {width for _, width in grasps(item)} == {0.05}  # 0.2 along x does not fit
    assert half_height(item, to_transform(item.pose)) == pytest.approx(0.015)


@pytest.mark.parametrize(
    "shape", [Cylinder(radius=0.02, length=0.1), Sphere(radius=0.02)]
)
def test_a_round_thing_is_taken_from_any_side(shape: Solid) -> None:
    found = grasps(thing(shape))
    assert len(found) == 8
    assert {width for _, width in found} == {0.04}
    yaws = {round(math.atan2(p.rotation[1][0], p.rotation[0][0]), 6) for p, _ in found}
    assert len(yaws) == 8


@pytest.mark.parametrize(
    ("item", "named"),
    [
        (thing(Box(size=(0.1, 0.1, 0.1))), "100.0 mm"),
        (thing(Box(size=(0.04, 0.04, 0.04)), rpy=(0.5, 0.0, 0.0)), "'thing'"),
        (thing(Cylinder(radius=0.02, length=0.1), rpy=(1.57, 0.0, 0.0)), "'thing'"),
        (thing(Mesh(uri="a.stl", path=Path("a.stl"))), "'thing'"),
        (thing(Compound(parts=((Sphere(radius=0.01), Pose()),))), "several shapes"),
    ],
)
def test_what_cannot_be_grasped_is_refused(item: SceneObject, named: str) -> None:
    with pytest.raises(ControlError) as caught:
        grasps(item)
    assert named in str(caught.value)


def test_the_fingers_reach_as_far_as_their_pads() -> None:
    model = assemble(mount_rpy=(0.0, 0.0, 0.7)).model
    assert finger_reach(model, model.grippers[0]) == pytest.approx(0.0375 / 2.0)


def test_pads_without_a_box_are_told() -> None:
    model = assemble().model
    bare = replace(
        model, links=tuple(replace(link, collisions=()) for link in model.links)
    )
    with pytest.raises(ControlError) as caught:
        finger_reach(bare, bare.grippers[0])
    assert "'left_inner_finger_pad'" in str(caught.value)


SIZE = (0.3, 0.2, 0.1)
WALLS = bin_walls("crate", size=SIZE, pose=Pose(xyz=(0.5, -0.3, 0.05)))


def test_the_corners_of_a_bin_are_those_of_its_walls() -> None:
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
def test_what_is_in_a_bin(position: tuple[float, float, float], is_in: bool) -> None:
    assert find_bin(WALLS, "crate").holds(Transform(position=position)) is is_in


def test_a_scene_without_a_bin() -> None:
    with pytest.raises(ControlError) as caught:
        find_bin(WALLS, "crates")
    assert "'crates'" in str(caught.value)
    assert find_bin(load_scene("table_and_bin").objects, "bin").center[1] < 0.0
