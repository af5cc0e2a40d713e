"""Objects beside the robot: they rest, they go back, and they disturb no joint."""

from __future__ import annotations

import dataclasses
import logging
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from objects_rig import EDGE, REST, cube, engine_with, item, run, tetrahedron

from tool0.description.loading import assemble, named_poses
from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box, Cylinder, Mesh, Sphere
from tool0.description.transform import Pose
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import DivergenceError, ModelError


def test_poses_come_in_the_order_of_the_scene_and_of_objects_as_placed(
    skew_model: RobotModel, tmp_path: Path
) -> None:
    turned = (0.3, -0.2, 0.5)
    objects = (
        item("part", tetrahedron(tmp_path / "part.stl"), 1.0, rpy=turned),
        item("table", Box(size=(1.0, 1.0, 0.04)), 0.1, x=9.0, rpy=turned, mass=None),
        item("ball", Sphere(radius=0.1), 2.0, rpy=turned),
        item("post", Cylinder(radius=0.1, length=1.0), 3.0, x=7.0, mass=None),
    )
    poses = engine_with(skew_model, *objects).world.object_states()
    assert [pose.name for pose in poses] == ["part", "table", "ball", "post"]
    assert [pose.position for pose in poses] == [o.pose.xyz for o in objects]
    half = np.divide(turned, 2.0)
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    expected = (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
    for pose in poses[:3]:
        np.testing.assert_allclose(pose.quat_wxyz, expected, atol=1e-12)
    assert poses[3].quat_wxyz == (1.0, 0.0, 0.0, 0.0)


def test_the_joints_of_the_robot_stay_the_first(tmp_path: Path) -> None:
    description = assemble()
    model, up = description.model, named_poses(description)["up"]
    objects = (
        cube(z=1.0),
        item("can", Cylinder(radius=0.03, length=0.1), 2.0),
        item("table", Box(size=(1.0, 1.0, 0.04)), 0.1, mass=None),
        item("part", tetrahedron(tmp_path / "part.stl"), 3.0),
    )
    bare, engine = MujocoEngine(model), MujocoEngine(model, scene=Scene(objects))
    assert engine.joint_names == bare.joint_names
    start = [up.get(name, 0.0) for name in bare.joint_names]
    for each in (bare, engine):
        each.reset(start)
        assert each.read().position == start
        assert each.read().velocity == [0.0] * len(start)
    for _ in range(50):
        for each in (bare, engine):
            each.write([1.0] * len(start))
            each.step()
    # Objects that touch nothing change nothing but the last digits.
    assert len(engine.read().velocity) == len(start)
    for one, other in (
        (engine.read().position, bare.read().position),
        (engine.read().velocity, bare.read().velocity),
    ):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    "resting",
    [
        (cube(),),
        (cube("low"), cube("high", z=1.5 * EDGE)),
        (item("can", Cylinder(radius=0.03, length=0.1), 0.05),),
        (item("log", Cylinder(radius=0.03, length=0.1), 0.03, rpy=(1.5708, 0, 0)),),
        (item("ball", Sphere(radius=0.02), 0.02),),
        (item("heavy", Box(size=(0.2, 0.2, 0.2)), 0.1, mass=50.0),),
        (item("slippery", Box(size=(0.1, 0.1, 0.1)), 0.05, friction=0.05),),
    ],
    ids=lambda objects: objects[-1].name,
)
def test_what_lies_stays(
    skew_model: RobotModel, resting: tuple[SceneObject, ...]
) -> None:
    engine = engine_with(skew_model, *resting)
    before = engine.world.object_states()
    run(engine, 5.0)
    for start, end in zip(before, engine.world.object_states(), strict=True):
        np.testing.assert_allclose(end.position, start.position, atol=1e-4)
        np.testing.assert_allclose(end.quat_wxyz, start.quat_wxyz, atol=1e-3)


def test_a_mesh_rests_on_its_face_and_has_its_own_origin(
    skew_model: RobotModel, tmp_path: Path
) -> None:
    part = item("part", tetrahedron(tmp_path / "part.stl"), 0.0)
    engine = engine_with(skew_model, part)
    run(engine, 2.0)
    (pose,) = engine.world.object_states()
    np.testing.assert_allclose(pose.position, part.pose.xyz, atol=1e-4)
    # A tetrahedron's inertia about its centre, from its mass and legs.
    np.testing.assert_allclose(engine.model.body("part").mass, 0.1, rtol=1e-9)
    np.testing.assert_allclose(
        sum(engine.model.body("part").inertia), 3 * 3 / 40 * 0.1 * 0.1**2, rtol=1e-4
    )


def test_a_reset_puts_everything_back_to_the_bit(skew_model: RobotModel) -> None:
    still = item("shelf", Box(size=(0.5, 0.5, 0.02)), 0.3, mass=None)
    engine = engine_with(skew_model, cube(z=0.5), still, cube("low", z=0.02))
    before = engine.world.object_states()

    def fall() -> object:
        run(engine, 0.7)
        return engine.world.object_states(), engine.read()

    after = fall()
    assert engine.world.object_states()[0] != before[0]
    assert engine.world.object_states()[1] == before[1]
    engine.reset(REST)
    assert engine.world.object_states() == before
    assert fall() == after


def test_recorded_states_are_those_of_then_whenever_they_are_read(
    skew_model: RobotModel,
) -> None:
    still = item("shelf", Box(size=(0.5, 0.5, 0.02)), 0.3, mass=None)
    engine, twin = (engine_with(skew_model, cube(z=1.0), still) for _ in range(2))
    for each in (engine, twin):
        run(each, 0.1)
    read, unread = engine.world.object_states(), twin.world.object_states()
    expected = tuple(read)
    for each in (engine, twin):
        each.world.place(dataclasses.replace(expected[1], position=(3.0, 0.0, 0.3)))
        each.world.place(dataclasses.replace(expected[0], position=(0.0, 2.0, 0.5)))
        run(each, 0.1)
    assert unread == read == expected
    assert hash(unread) == hash(expected)
    assert unread[1] is unread[1]
    assert list(unread[:1]) == [expected[0]]
    twin.world.delete("shelf")
    assert len(unread) == 2
    assert pickle.loads(pickle.dumps(twin.world.object_states())) != unread


@pytest.mark.parametrize(
    ("cube_mu", "slope_mu", "slides"),
    [(0.5, 1.0, False), (0.2, 1.0, True), (1.0, 0.2, True), (0.5, 0.5, False)],
)
def test_the_smaller_friction_counts(
    skew_model: RobotModel, cube_mu: float, slope_mu: float, slides: bool
) -> None:
    tilt = 0.3  # [rad]; tan 0.3 = 0.31
    normal = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    slope = item(
        "slope",
        Box(size=(2.0, 1.0, 0.1)),
        1.0,
        rpy=(0.0, tilt, 0.0),
        mass=None,
        friction=slope_mu,
    )
    x, y, z = np.array(slope.pose.xyz) + (0.05 + EDGE / 2) * normal
    box = SceneObject(
        name="cube",
        geometry=Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=(x, y, z), rpy=(0.0, tilt, 0.0)),
        mass=0.1,
        friction=cube_mu,
    )
    engine = engine_with(skew_model, slope, box)
    run(engine, 0.5)
    way = math.dist(engine.world.object_states()[1].position, (x, y, z))
    if slides:  # with the acceleration that Coulomb's law gives
        pull = 9.81 * (math.sin(tilt) - 0.2 * math.cos(tilt))
        assert way == pytest.approx(pull * 0.5**2 / 2, rel=0.03)
    else:
        assert way < 1e-4


def test_objects_in_each_other_are_a_warning_that_names_what_moves_first(
    skew_model: RobotModel, caplog: pytest.LogCaptureFixture
) -> None:
    table = item("table", Box(size=(1.0, 1.0, 0.04)), 0.5, mass=None)
    ball = item("ball", Sphere(radius=0.02), 0.52 + 0.02 - 0.003)
    with caplog.at_level(logging.WARNING):
        engine_with(skew_model, ball, table)
    (record,) = caplog.records
    assert record.getMessage().startswith("the pose puts 'ball' 3.0 mm into 'table'")


@pytest.mark.parametrize("content", [b"", b"no mesh", bytes(84), b"solid x\nfacet"])
@pytest.mark.parametrize("name", ["broken.stl", "part.dae"])
def test_a_mesh_that_cannot_be_read_is_an_error_that_names_the_object(
    skew_model: RobotModel, tmp_path: Path, name: str, content: bytes
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    mesh = Mesh(uri=name, path=path)
    with pytest.raises(ModelError) as error:
        engine_with(skew_model, cube(), item("part", mesh, 1.0))
    assert "'part'" in str(error.value)


def test_an_object_that_diverges_is_named(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model, cube(), cube("other", z=1.0))
    engine.step()
    engine.data.qvel[-1] = math.nan
    with pytest.raises(DivergenceError) as error:
        engine.read()
    assert (error.value.joint, error.value.time) == ("other", 0.001)
    engine.reset(REST)
    engine.read()


def test_a_changed_object_is_as_if_compiled(skew_model: RobotModel) -> None:
    """To the bit, in all that MuJoCo's steps read."""

    def objects(factor: float) -> list[SceneObject]:
        shapes = (
            Box(size=(0.1 * factor, 0.2, 0.05 / factor)),
            Cylinder(radius=0.1 * factor, length=0.2),
            Sphere(radius=0.1 * factor),
        )
        return [
            item(
                f"{kind}{k}",
                shape,
                0.3 * k,
                x=x,
                mass=None if kind == "fixed" else 0.3 / factor,
                rpy=(0.2, 0.1, k),
            )
            for kind, x in (("free", 5.0), ("fixed", 6.0))
            for k, shape in enumerate(shapes)
        ]

    changed = engine_with(skew_model, *objects(1.0))
    compiled = engine_with(skew_model, *objects(1.3)).model
    before = _numbers(changed.model)
    for each in objects(1.3):
        changed.world.change(each)
    now = _numbers(changed.model)
    differ = {name for name in now if not np.array_equal(now[name], before[name])}
    assert differ >= {"geom_size", "geom_rbound", "geom_aabb", "body_inertia"}
    for name, values in _numbers(compiled).items():
        np.testing.assert_array_equal(now[name], values, err_msg=name)
    for each in objects(1.0):
        changed.world.change(each)
    for name, values in _numbers(changed.model).items():
        np.testing.assert_array_equal(before[name], values, err_msg=name)


def _numbers(model: Any) -> dict[str, np.ndarray]:
    """Return all numbers of a model, and the mean inertia among its statistics.

    The other statistics are for viewers.
    """
    arrays = ((name, getattr(model, name)) for name in dir(model))
    found = {
        name: values.copy()
        for name, values in arrays
        if isinstance(values, np.ndarray) and values.dtype.kind in "biuf"
    }
    return {**found, "meaninertia": np.array(model.stat.meaninertia)}
