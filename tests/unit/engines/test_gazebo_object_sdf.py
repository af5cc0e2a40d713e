"""Objects as Gazebo takes them, and where their mass is."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.engines.gazebo.sdf import object_sdf, unit_inertia
from tool0.errors import ModelError

SIZE = np.array([0.1, 0.2, 0.3])
AT = np.array([1.0, -2.0, 0.5])
CORNERS = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3, indexing="ij")).reshape(3, 8).T
QUADS = [
    (0, 1, 3, 2),
    (4, 6, 7, 5),
    (0, 4, 5, 1),
    (2, 3, 7, 6),
    (0, 2, 6, 4),
    (1, 5, 7, 3),
]


def obj(path: Path) -> Path:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in (CORNERS * SIZE + AT).tolist()]
    lines += ["f " + " ".join(f"{i + 1}//1" for i in quad) for quad in QUADS]
    path.write_text("# a box\n" + "\n".join(lines))
    return path


def triangles() -> np.ndarray:
    corners = CORNERS * SIZE + AT
    return np.array(
        [corners[[a, b, c]] for a, *rest in QUADS for b, c in (rest[:2], rest[1:])]
    )


def binary_stl(path: Path) -> Path:
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in triangles())
    path.write_bytes(b"solid".ljust(80) + struct.pack("<I", 12) + facets)
    return path


def text_stl(path: Path) -> Path:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corner) for corner in t.tolist())
        + "endloop\nendfacet\n"
        for t in triangles()
    )
    path.write_text(f"solid a box\n{facets}endsolid")
    return path


@pytest.mark.parametrize("write", [obj, binary_stl, text_stl])
def test_a_mesh_weighs_as_what_it_encloses(write: object, tmp_path: Path) -> None:
    suffix = ".obj" if write is obj else ".stl"
    path = write(tmp_path / f"box{suffix}")  # type: ignore[operator]
    mesh = Mesh(uri=path.name, path=path, scale=(2.0, -1.0, 0.5))
    solid = unit_inertia(mesh)
    x, y, z = (SIZE * np.abs(mesh.scale)).tolist()
    expected = unit_inertia(Box(size=(x, y, z)))
    np.testing.assert_allclose(solid.center, AT * mesh.scale, rtol=1e-5)
    np.testing.assert_allclose(solid.tensor, expected.tensor, rtol=1e-4, atol=1e-8)


@pytest.mark.parametrize(
    ("geometry", "moments"),
    [
        (Box(size=(1.0, 2.0, 3.0)), (13 / 12, 10 / 12, 5 / 12)),
        (Cylinder(radius=1.0, length=2.0), (7 / 12, 7 / 12, 1 / 2)),
        (Sphere(radius=2.0), (1.6, 1.6, 1.6)),
    ],
)
def test_moments_of_solids(
    geometry: Geometry, moments: tuple[float, float, float]
) -> None:
    np.testing.assert_allclose(unit_inertia(geometry).tensor, np.diag(moments))


def test_a_mesh_that_encloses_nothing_may_only_stand_still(tmp_path: Path) -> None:
    path = tmp_path / "sheet.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    mesh = Mesh(uri=path.name, path=path)
    assert "<mesh>" in object_sdf(SceneObject(name="sheet", geometry=mesh))
    with pytest.raises(ModelError) as error:
        object_sdf(SceneObject(name="sheet", geometry=mesh, mass=1.0))
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("name", "data"),
    [("part.stl", b""), ("part.obj", b"v 0 0\nf 1 2 3"), ("part.obj", b"f a b c")],
)
def test_what_cannot_be_read_is_named(name: str, data: bytes, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(ModelError) as error:
        unit_inertia(Mesh(uri=name, path=path))
    assert name in str(error.value)


def test_an_object_is_a_model_with_its_mass_colour_and_friction() -> None:
    item = SceneObject(
        name="thing",
        geometry=Box(size=(0.1, 0.2, 0.3)),
        mass=2.0,
        friction=0.4,
        rgba=(1.0, 0.5, 0.25, 0.75),
    )
    model = ET.fromstring(object_sdf(item)).find("model")
    assert model is not None
    assert model.get("name") == "thing"
    assert model.findtext("static") == "false"
    assert model.findtext("link/inertial/mass") == "2.0"
    inertia = model.find("link/inertial/inertia")
    assert inertia is not None
    tags = [element.tag for element in inertia]
    assert tags == ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]
    assert float(inertia.findtext("ixx", "")) == pytest.approx(2.0 * 0.13 / 12)
    assert model.findtext("link/collision/geometry/box/size") == "0.1 0.2 0.3"
    assert model.findtext("link/collision/surface/friction/ode/mu") == "0.4"
    assert model.findtext("link/visual/material/diffuse") == "1.0 0.5 0.25 0.75"
    assert float(model.findtext("link/visual/transparency", "")) == 0.25


def test_what_has_no_mass_stands_still() -> None:
    text = object_sdf(SceneObject(name="table", geometry=Sphere(radius=1.0)))
    assert "<static>true</static>" in text
    assert "inertial" not in text
