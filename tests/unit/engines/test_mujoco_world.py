"""Objects and attachments that come and go: everything else keeps its state."""

from __future__ import annotations

import logging
from pathlib import Path

import mujoco
import numpy as np
import pytest
from objects_rig import EDGE, FAR, REST, cube, engine_with, run, state_of

from tool0.description.model import RobotModel
from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Mesh
from tool0.description.transform import Pose
from tool0.engines.mujoco.engine import MujocoEngine

LINK = "cap"
WEIGHT = 0.1 * 9.81  # [N]


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
    run(engine, 0.2)
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
        run(each, 0.3)
    engine.world.spawn(cube("b", z=0.02))
    engine.world.delete("b")
    for each in (engine, twin):
        each.write([0.3, 0.0, -0.1, 0.0])
        run(each, 0.3)
    assert engine.read() == twin.read()
    assert engine.world.object_states() == twin.world.object_states()


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


def test_an_object_may_be_called_as_a_joint(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model)
    engine.world.spawn(cube(engine.joint_names[0]))
    assert engine.read().position == REST
    run(engine, 0.01)


def test_what_stands_still_stays_where_it_was_placed(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model, cube("post", mass=None), cube("other", 6.0))
    placed = ObjectState("post", (7.0, 1.0, 0.5), (0.0, 1.0, 0.0, 0.0))
    began = engine.world.object_states()[0]
    engine.world.place(placed)
    engine.world.spawn(cube("on it", 7.0, 0.6))
    engine.world.delete("other")
    assert engine.world.object_states()[0] == placed
    engine.world.place(ObjectState("on it", (7.0, 1.0, 0.55), (1.0, 0.0, 0.0, 0.0)))
    run(engine, 0.5)
    height = engine.world.object_states()[1].position[2]
    assert height == pytest.approx(0.5 + EDGE, abs=1e-4)
    engine.reset(REST)
    assert engine.world.object_states()[0] == began


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


def test_contacts_of_the_last_step_survive_what_comes(skew_model: RobotModel) -> None:
    engine = engine_with(skew_model, cube("low"), cube("high", z=1.5 * EDGE))
    run(engine, 1.0)
    before = engine.world.contacts()
    for contact, names, weight, z in zip(
        before,
        ({"low", "ground"}, {"low", "high"}),
        (2 * WEIGHT, WEIGHT),
        (0.0, EDGE),
        strict=True,
    ):
        assert {contact.first, contact.second} == names
        assert np.abs(contact.force) == pytest.approx(
            [0, 0, weight], rel=0.02, abs=0.01
        )
        assert contact.point == pytest.approx((FAR, 0.0, z), abs=1e-4)
        assert contact.torque == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)
    engine.world.spawn(cube("other", 2 * FAR))
    assert engine.world.contacts() == before
    run(engine, 0.5)
    assert len(engine.world.contacts()) == 3


def pose_on_link(engine: MujocoEngine, name: str) -> np.ndarray:
    """Return the object's current pose in the link's frame."""
    mujoco.mj_kinematics(engine.model, engine.data)
    site, body = engine.data.site(LINK), engine.data.body(name)
    rotation = site.xmat.reshape(3, 3).T
    position: np.ndarray = rotation @ (body.xpos - site.xpos)
    return np.concatenate([position, (rotation @ body.xmat.reshape(3, 3)).ravel()])


def test_an_attachment_changes_no_state_and_lasts_while_others_come_and_go(
    skew_model: RobotModel,
) -> None:
    # tests/conformance has the rest
    engine = engine_with(
        skew_model, cube("held", 0.5, 1.0), cube("free", 3.0, 1.0), ground=None
    )
    run(engine, 0.1)
    before, joints = engine.world.object_states(), engine.read()
    engine.world.attach("held", LINK)
    assert engine.world.object_states() == before
    assert engine.read() == joints
    place = pose_on_link(engine, "held")
    run(engine, 0.3)
    assert engine.read().position != joints.position  # the limp robot falls
    assert state_of(engine, "free").linear[2] == pytest.approx(-9.81 * 0.4, rel=0.01)
    engine.world.delete("free")
    run(engine, 0.05)
    engine.world.spawn(cube("late", 5.0, 1.0))
    engine.world.attach("late", LINK)
    run(engine, 0.05)
    np.testing.assert_allclose(pose_on_link(engine, "held"), place, atol=2e-3)
    engine.world.delete("late")
    assert {contact.second for contact in engine.world.contacts()} == {"held", "late"}
    engine.reset(REST)
    run(engine, 0.1)
    assert state_of(engine, "held").linear[2] == pytest.approx(-9.81 * 0.1, rel=0.01)
    assert engine.world.contacts() == ()
