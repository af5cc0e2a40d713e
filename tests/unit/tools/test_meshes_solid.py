from collections import Counter

import numpy as np
import pytest
from meshes.solid import AXES, block, plate, rounded, turned

pytestmark = pytest.mark.slow

SOLIDS = {
    "cylinder": turned(rounded(0.05, 0.0, 0.1)),
    "cylinder downwards": turned(rounded(0.05, 0.1, 0.0)),
    "rounded cylinder": turned(rounded(0.05, 0.0, 0.1, below=0.02, above=0.01)),
    "cone": turned([(0.05, 0.0), (0.0, 0.1)]),
    "plate": plate([(0.0, 0.0, 0.01), (0.05, 0.0, 0.006)], x=(-0.01, 0.01)),
    "block": block([(0.03, 0.03, 0.03, 0.0), (0.02, 0.03, 0.01, 0.05)]),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_every_edge_is_shared_by_two_triangles_that_run_it_opposite_ways(
    name: str,
) -> None:
    triangles = SOLIDS[name].triangles
    edges = Counter(
        (int(a), int(b))
        for row in triangles
        for a, b in zip(row, np.roll(row, -1), strict=True)
    )
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)


@pytest.mark.parametrize("name", SOLIDS)
def test_normals_point_outwards(name: str) -> None:
    solid = SOLIDS[name]
    a, b, c = solid.corners.transpose(1, 0, 2)
    inside = solid.vertices.mean(axis=0)  # all of these are convex
    outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - inside)
    assert solid.volume > 0
    assert outwards.min() > -1e-12


def test_a_fine_cylinder_has_the_volume_of_a_round_one() -> None:
    solid = turned(rounded(0.05, 0.0, 0.1), segments=512)
    assert solid.volume == pytest.approx(np.pi * 0.05**2 * 0.1, rel=1e-4)


def test_a_plate_has_the_volume_of_its_hull() -> None:
    solid = plate(
        [(0.0, 0.0, 0.01), (0.05, 0.0, 0.01)], x=(0.0, 0.02), chamfer=0, segments=512
    )
    area = np.pi * 0.01**2 + 0.02 * 0.05
    assert solid.volume == pytest.approx(area * 0.02, rel=1e-3)


@pytest.mark.parametrize("axis", AXES)
def test_a_turned_part_points_along_its_axis(axis: str) -> None:
    solid = turned(rounded(0.01, 0.2, 0.3), axis=axis)
    sign = {"+": 1.0, "-": -1.0}[axis[0]]
    heights = sign * solid.vertices[:, "xyz".index(axis[1])]
    assert heights.min() == pytest.approx(0.2)
    assert heights.max() == pytest.approx(0.3)
    assert np.linalg.det(np.array(AXES[axis])) == pytest.approx(1.0)
