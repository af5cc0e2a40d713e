"""Bodies of several shapes: where the engines put their mass."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest
from objects_rig import REST, engine_with, item, tetrahedron

from tool0.description.model import RobotModel
from tool0.description.shapes import Box, Compound, Cylinder, Sphere
from tool0.description.transform import Pose, pose_matrix
from tool0.engines.gazebo.sdf import object_sdf, unit_inertia, volume
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import ModelError

MASS = 2.5  # [kg]


def odd_body(folder: Path) -> Compound:
    """Return one part of each kind, each at a skew pose."""
    return Compound(
        parts=(
            (Box(size=(0.1, 0.2, 0.3)), Pose(xyz=(0.3, 0.1, 0.0), rpy=(0.1, 0.2, 0.3))),
            (Cylinder(radius=0.1, length=0.4), Pose(xyz=(0.0, 0.5, 0.2))),
            (Sphere(radius=0.15), Pose(xyz=(-0.4, 0.0, -0.1))),
            (tetrahedron(folder / "part.stl"), Pose(rpy=(1.0, -0.5, 2.0))),
        )
    )


def test_volumes(tmp_path: Path) -> None:
    assert volume(Box(size=(1.0, 2.0, 3.0))) == 6.0
    assert volume(Cylinder(radius=2.0, length=3.0)) == pytest.approx(12.0 * np.pi)
    assert volume(Sphere(radius=3.0)) == pytest.approx(36.0 * np.pi)
    mesh = tetrahedron(tmp_path / "part.stl")
    assert volume(mesh) == pytest.approx(1e-3 / 6.0)


def test_the_engines_agree_about_mass_centre_and_inertia(
    skew_model: RobotModel, tmp_path: Path
) -> None:
    solid = odd_body(tmp_path)
    engine = engine_with(skew_model, item("odd", solid, 2.0, mass=MASS))
    unit = unit_inertia(solid)
    np.testing.assert_allclose(unit.mass, 1.0)
    body = compiled(engine).body("odd")
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, body.iquat)
    R = axes.reshape(3, 3)
    np.testing.assert_allclose(body.mass, MASS)
    np.testing.assert_allclose(body.ipos, unit.center, atol=1e-7)
    tensor = R @ np.diag(body.inertia) @ R.T
    np.testing.assert_allclose(tensor, MASS * unit.tensor, rtol=1e-5, atol=1e-7)


def compiled(engine: MujocoEngine) -> mujoco.MjModel:
    return engine.world._model


def test_a_dumbbell_s_inertia_follows_from_the_parallel_axes() -> None:
    r, d = 0.1, 0.4
    ball = Sphere(radius=r)
    solid = Compound(
        parts=((ball, Pose(xyz=(-d, 0.0, 0.0))), (ball, Pose(xyz=(d, 0.0, 0.0))))
    )
    own = 0.4 * r * r
    unit = unit_inertia(solid)
    np.testing.assert_allclose(unit.center, np.zeros(3), atol=1e-15)
    expected = np.diag([own, own + d * d, own + d * d])
    np.testing.assert_allclose(unit.tensor, expected, atol=1e-15)


def test_one_part_is_as_that_shape_alone_at_its_pose() -> None:
    box, pose = (
        Box(size=(0.1, 0.2, 0.3)),
        Pose(xyz=(1.0, 2.0, 3.0), rpy=(0.1, 0.2, 0.3)),
    )
    unit, alone = unit_inertia(Compound(parts=((box, pose),))), unit_inertia(box)
    R = pose_matrix(pose)[:3, :3]
    np.testing.assert_allclose(unit.center, pose.xyz)
    np.testing.assert_allclose(unit.tensor, R @ alone.tensor @ R.T)


def test_gazebo_gets_every_part_once_and_one_inertial(tmp_path: Path) -> None:
    solid = odd_body(tmp_path)
    root = ET.fromstring(object_sdf(item("odd", solid, 0.0, mass=MASS)))
    (link,) = root.iter("link")
    assert len(link.findall("inertial")) == 1
    numbered = ["", "_1", "_2", "_3"]
    for kind in ("collision", "visual"):
        shapes = link.findall(kind)
        assert [one.get("name") for one in shapes] == [kind + n for n in numbered]
        poses = [one.findtext("pose", "").split() for one in shapes]
        assert [tuple(map(float, pose)) for pose in poses] == [
            (*pose.xyz, *pose.rpy) for _, pose in solid.parts
        ]


def test_parts_keep_their_mass_when_a_file_is_gone(
    skew_model: RobotModel, tmp_path: Path
) -> None:
    """MuJoCo compiles all objects again when another one comes."""
    solid = odd_body(tmp_path)
    engine = engine_with(skew_model, item("odd", solid, 2.0, mass=MASS))
    before = compiled(engine).body("odd").inertia.copy()
    (tmp_path / "part.stl").unlink()
    engine.world.spawn(item("ball", Sphere(radius=0.1), 5.0))
    np.testing.assert_array_equal(compiled(engine).body("odd").inertia, before)
    np.testing.assert_allclose(compiled(engine).body("odd").mass, MASS)


def test_a_part_that_is_no_mesh_is_named_with_its_object(
    skew_model: RobotModel, tmp_path: Path
) -> None:
    solid = odd_body(tmp_path)
    (tmp_path / "part.stl").write_bytes(b"nothing")
    engine = engine_with(skew_model)
    engine.reset(REST)
    with pytest.raises(ModelError, match="'odd'"):
        engine.world.spawn(item("odd", solid, 2.0, mass=MASS))
