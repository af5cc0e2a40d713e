"""Objects that come and go: everything else keeps its state to the bit."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import numpy as np
import pytest

from tool0.description.catalogue import assemble, named_poses
from tool0.description.model import Box, Mesh, Pose, RobotModel, Sphere
from tool0.description.scene import Scene, SceneObject
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import EngineError, ModelError
from tool0.hardware.engine import Engine, ObjectState

REST = [0.0, 0.0, 0.0, 0.2]  # the skew robot's joints
EDGE = 0.04  # [m]


def cube(
    name: str,
    x: float = 5.0,
    z: float = EDGE / 2,
    *,
    mass: float | None = 0.1,
    friction: float = 1.0,
) -> SceneObject:
    return SceneObject(
        name=name,
        geometry=Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=(x, 0.0, z)),
        mass=mass,
        friction=friction,
    )


def engine_with(model: RobotModel, *objects: SceneObject) -> MujocoEngine:
    engine = MujocoEngine(model, scene=Scene(objects))
    engine.reset(REST)
    return engine


def let_pass(engine: Engine, duration: float) -> None:
    for _ in range(round(duration / engine.dt)):
        engine.step()
        engine.read()


def whole_state(engine: MujocoEngine, names: list[str]) -> list[list[float]]:
    """Return time, control and what each joint of ``names`` has of the state."""
    data = engine.data
    joints = [data.joint(name) for name in names]
    return [
        [data.time],
        data.ctrl.tolist(),
        *(
            [*joint.qpos, *joint.qvel, *joint.qacc_warmstart, *joint.qfrc_applied]
            for joint in joints
        ),
    ]


def test_what_stays_keeps_its_whole_state(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model, cube("a", z=0.3), cube("b", 6.0), cube("c", 7.0))
    names = [*engine.joint_names, "a/free", "c/free"]
    engine.write([0.1, -0.2, 0.3, 0.0])
    let_pass(engine, 0.2)
    before, read = whole_state(engine, names), engine.read()
    engine.world.delete("b")
    assert whole_state(engine, names) == before
    engine.world.spawn(cube("d", 8.0, 0.5))
    engine.world.spawn(cube("post", 9.0, mass=None))
    assert whole_state(engine, names) == before
    assert engine.read() == read
    assert [state.name for state in engine.world.object_states()] == [
        "a",
        "c",
        "d",
        "post",
    ]


def test_no_further_state_is_lost_on_the_way(skew_model: RobotModel) -> None:
    """An object that comes and goes within a step leaves no trace in any later one."""
    engine, twin = (engine_with(skew_model, cube("a", z=0.1)) for _ in range(2))
    for each in (engine, twin):
        each.write([0.1, -0.2, 0.3, 0.0])
        let_pass(each, 0.3)
    engine.world.spawn(cube("b", z=0.02))
    engine.world.delete("b")
    for each in (engine, twin):
        each.write([0.3, 0.0, -0.1, 0.0])
        let_pass(each, 0.3)
    assert engine.read() == twin.read()
    assert engine.world.object_states() == twin.world.object_states()


def test_what_is_held_is_held_on_while_others_come_and_go() -> None:
    """Also what fingers squeeze: the contact goes on where it was."""
    description = assemble()
    engine = MujocoEngine(description.model, ground=-0.1)
    pose = named_poses(description)["home"]
    engine.reset([pose.get(name, 0.0) for name in engine.joint_names])
    drive = engine.joint_names.index("finger_joint")
    for name in ("first", "second"):
        engine.world.spawn(cube(name, 2.0))
    effort = [0.0] * len(engine.joint_names)
    effort[drive] = 0.5
    engine.write(effort)
    for i in range(20):
        engine.step()
        before = engine.read()
        engine.world.spawn(cube(f"cube{i}", 3.0 + i))
        assert engine.read() == before
    assert engine.read().velocity[drive] > 0.0
    assert engine.read().effort == effort


@pytest.mark.parametrize("mu", [0.1, 1.0])
def test_what_comes_has_the_friction_of_what_was_there(
    skew_model: RobotModel, mu: float
) -> None:
    def pairs(engine: MujocoEngine) -> set[tuple[str, str, tuple[float, ...]]]:
        model = engine.model
        return {
            (
                model.geom(int(model.pair_geom1[i])).name,
                model.geom(int(model.pair_geom2[i])).name,
                tuple(model.pair_friction[i]),
            )
            for i in range(model.npair)
        }

    first, second = cube("first"), cube("second", 6.0, friction=mu)
    there = engine_with(skew_model, first, second)
    came = engine_with(skew_model, first)
    came.world.spawn(second)
    assert pairs(came) == pairs(there) != set()


def test_what_is_refused_leaves_everything_as_it_was(
    skew_model: RobotModel, tmp_path: Path
) -> None:
    engine = engine_with(skew_model, cube("cube"))
    let_pass(engine, 0.05)
    model, data, before = engine.model, engine.data, engine.world.object_states()
    broken = tmp_path / "broken.stl"
    broken.write_bytes(b"no mesh")
    part = SceneObject(name="part", geometry=Mesh(uri="broken.stl", path=broken))
    with pytest.raises(EngineError) as taken:
        engine.world.spawn(cube("cube"))
    assert "'cube'" in str(taken.value)
    with pytest.raises(ModelError) as refused_mesh:
        engine.world.spawn(part)
    assert "'part'" in str(refused_mesh.value)
    for refused in (
        engine.world.delete,
        lambda name: engine.world.place(ObjectState(name, *HERE)),
    ):
        with pytest.raises(EngineError) as unknown:
            refused("cub")
        assert "'cube'" in str(unknown.value)
    assert engine.model is model
    assert engine.data is data
    assert engine.world.object_states() == before
    engine.world.spawn(cube("other", 6.0))


def test_an_object_outlives_the_file_of_its_mesh(
    skew_model: RobotModel, tmp_path: Path
) -> None:
    path = tmp_path / "part.obj"

    def write(size: float) -> SceneObject:
        corners = ("0 0 0", f"{size} 0 0", f"0 {size} 0", f"0 0 {size}")
        faces = ("1 3 2", "1 2 4", "1 4 3", "2 3 4")
        lines = [*(f"v {at}" for at in corners), *(f"f {face}" for face in faces)]
        path.write_text("\n".join(lines))
        mesh = Mesh(uri="part.obj", path=path)
        return SceneObject(
            name="part", geometry=mesh, pose=Pose(xyz=(8.0, 0.0, 1.0)), mass=1.0
        )

    def inertia(engine: MujocoEngine) -> float:
        return float(engine.model.body("part").inertia.sum())

    engine = engine_with(skew_model)
    engine.world.spawn(write(0.1))
    small = inertia(engine)
    path.unlink()
    engine.world.spawn(cube("cube"))
    assert inertia(engine) == small
    part = write(0.2)
    engine.world.delete("cube")
    assert inertia(engine) == small  # made of what the file was
    engine.world.delete("part")
    engine.world.spawn(part)
    assert inertia(engine) == pytest.approx(4.0 * small)


HERE = (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0)


def test_an_object_may_be_called_as_a_joint(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model)
    engine.world.spawn(cube(engine.joint_names[0]))
    assert engine.read().position == REST
    let_pass(engine, 0.01)


def test_velocities_are_in_the_axes_of_the_root(skew_model: RobotModel) -> None:
    ball = SceneObject(
        name="ball", geometry=Sphere(radius=0.1), pose=Pose(xyz=(5, 0, 2)), mass=1.0
    )
    engine = engine_with(skew_model, ball)
    rng = np.random.default_rng(seed=0)
    quat = rng.normal(size=4)
    quat /= np.linalg.norm(quat)
    linear, angular = rng.normal(size=(2, 3))
    placed = ObjectState(
        "ball",
        (5.0, 0.0, 2.0),
        tuple(quat.tolist()),
        tuple(linear.tolist()),
        tuple(angular.tolist()),
    )
    engine.world.place(placed)
    (seen,) = engine.world.object_states()
    assert seen.position == placed.position
    assert seen.linear == placed.linear
    np.testing.assert_allclose(seen.angular, placed.angular, atol=1e-12)
    let_pass(engine, 0.1)
    (later,) = engine.world.object_states()
    # a ball turns evenly about an axis that stands still in the root
    np.testing.assert_allclose(later.angular, angular, atol=1e-9)
    turn = np.linalg.norm(angular) * 0.1 / 2.0
    axis = angular / np.linalg.norm(angular)
    w, v = math.cos(turn), math.sin(turn) * axis
    expected = [
        w * quat[0] - v @ quat[1:],
        *(w * quat[1:] + quat[0] * v + np.cross(v, quat[1:])),
    ]
    np.testing.assert_allclose(later.quat_wxyz, expected, atol=1e-9)


def test_what_stands_still_stays_where_it_was_placed(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model, cube("post", mass=None), cube("other", 6.0))
    placed = ObjectState("post", (7.0, 1.0, 0.5), (0.0, 1.0, 0.0, 0.0))
    began = engine.world.object_states()[0]
    engine.world.place(placed)
    engine.world.spawn(cube("on it", 7.0, 0.6))
    engine.world.delete("other")
    assert engine.world.object_states()[0] == placed
    engine.world.place(ObjectState("on it", (7.0, 1.0, 0.55), (1.0, 0.0, 0.0, 0.0)))
    let_pass(engine, 0.5)
    height = engine.world.object_states()[1].position[2]
    assert height == pytest.approx(0.5 + EDGE, abs=1e-4)
    with pytest.raises(EngineError):
        engine.world.place(ObjectState("post", *HERE, angular=(0.0, 0.0, 1e-9)))
    engine.reset(REST)
    assert engine.world.object_states()[0] == began


def test_a_reset_may_begin_at_any_time(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model, cube("cube", z=0.4))
    let_pass(engine, 0.1)
    engine.world.spawn(cube("late", 6.0, 0.4))
    began = engine.world.object_states()[1]
    let_pass(engine, 0.1)
    engine.reset(REST, 1.234)
    assert engine.read().time == 1.234
    assert engine.world.object_states()[1] == began
    engine.step()
    assert engine.read().time == pytest.approx(1.235)


def test_what_comes_into_something_is_a_warning_about_it_alone(
    skew_model: RobotModel, caplog: pytest.LogCaptureFixture
) -> None:
    engine = engine_with(skew_model)
    with caplog.at_level(logging.WARNING):
        engine.world.spawn(cube("cube"))
        engine.world.spawn(cube("low", 6.0, EDGE / 2 - 0.005))
        engine.world.spawn(cube("far", 7.0))
    (record,) = caplog.records
    assert record.getMessage().startswith("the pose puts 'low' 5.0 mm into 'ground'")
