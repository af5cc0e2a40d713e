"""Objects fixed to links: they stay as they were until they are let go."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tool0.description.model import Box, Pose, RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import EngineError, ModelError
from tool0.hardware.engine import ObjectState

REST = [0.0, 0.0, 0.0, 0.2]  # the skew robot's joints
LINK = "cap"
MASS = 0.1  # [kg]


def cube(name: str, x: float, *, mass: float | None = MASS) -> SceneObject:
    return SceneObject(
        name=name,
        geometry=Box(size=(0.02, 0.02, 0.02)),
        pose=Pose(xyz=(x, 0.0, 1.0), rpy=(0.3, 0.2, 0.1)),
        mass=mass,
    )


@pytest.fixture
def engine(skew_model: RobotModel) -> MujocoEngine:
    things = cube("held", 0.5), cube("free", 3.0), cube("still", 4.0, mass=None)
    engine = MujocoEngine(skew_model, ground=None, scene=Scene(things))
    engine.reset(REST)
    return engine


def let_pass(engine: MujocoEngine, duration: float) -> None:
    for _ in range(round(duration / engine.dt)):
        engine.step()
        engine.read()  # raises if anything diverged


def state(engine: MujocoEngine, name: str) -> ObjectState:
    (found,) = [each for each in engine.world.object_states() if each.name == name]
    return found


def on_link(engine: MujocoEngine, name: str) -> np.ndarray:
    """Return where the object is on the link, as it is now."""
    mujoco.mj_kinematics(engine.model, engine.data)
    site, thing = engine.data.site(LINK), engine.data.body(name)
    rotation = site.xmat.reshape(3, 3).T
    placed: np.ndarray = rotation @ (thing.xpos - site.xpos)
    turned = rotation @ thing.xmat.reshape(3, 3)
    return np.concatenate([placed, turned.ravel()])


def test_an_attached_object_moves_with_the_link_until_it_is_detached(
    engine: MujocoEngine,
) -> None:
    let_pass(engine, 0.1)
    before, joints = engine.world.object_states(), engine.read()
    engine.world.attach("held", LINK)
    assert engine.world.object_states() == before
    assert engine.read() == joints
    place = on_link(engine, "held")
    let_pass(engine, 0.3)
    assert engine.read().position != joints.position  # the limp robot falls
    np.testing.assert_allclose(on_link(engine, "held"), place, atol=2e-3)
    assert state(engine, "free").linear[2] == pytest.approx(-9.81 * 0.4, rel=0.01)
    engine.world.detach("held")
    engine.world.detach("held")
    start = state(engine, "held").linear[2]
    let_pass(engine, 0.1)
    fallen = state(engine, "held").linear[2] - start
    assert fallen == pytest.approx(-9.81 * 0.1, rel=0.01)


def test_an_attachment_counts_as_a_contact(engine: MujocoEngine) -> None:
    engine.world.attach("held", "mount")
    let_pass(engine, 1.0)
    (contact,) = engine.world.contacts()
    assert (contact.first, contact.second) == ("mount", "held")
    np.testing.assert_allclose(contact.force, [0, 0, MASS * 9.81], atol=0.01)
    np.testing.assert_allclose(contact.torque, 0, atol=1e-4)
    np.testing.assert_allclose(contact.point, [0.5, 0, 1], atol=1e-3)


def test_it_stays_attached_while_others_come_and_go(engine: MujocoEngine) -> None:
    engine.world.attach("held", LINK)
    place = on_link(engine, "held")
    engine.world.delete("free")
    let_pass(engine, 0.05)
    engine.world.spawn(cube("late", 5.0))
    engine.world.attach("late", LINK)
    let_pass(engine, 0.05)
    engine.world.delete("late")
    let_pass(engine, 0.05)
    np.testing.assert_allclose(on_link(engine, "held"), place, atol=2e-3)


def test_placing_deleting_and_resetting_detach(engine: MujocoEngine) -> None:
    engine.world.attach("held", LINK)
    engine.world.place(ObjectState("held", (0.5, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)))
    let_pass(engine, 0.1)
    assert state(engine, "held").linear[2] == pytest.approx(-9.81 * 0.1, rel=0.01)
    engine.world.attach("held", LINK)
    engine.reset(REST)
    let_pass(engine, 0.1)
    assert state(engine, "held").linear[2] == pytest.approx(-9.81 * 0.1, rel=0.01)
    engine.world.attach("held", LINK)
    engine.world.delete("held")
    let_pass(engine, 0.1)
    assert engine.world.contacts() == ()


def test_attachments_that_cannot_be_are_refused_by_name(engine: MujocoEngine) -> None:
    engine.world.attach("free", LINK)
    for kind, name, link, named in (
        (ModelError, "held", "cab", "'cap'"),
        (EngineError, "hald", LINK, "'held'"),
        (EngineError, "still", LINK, "'still'"),
        (EngineError, "free", LINK, f"'{LINK}'"),
    ):
        with pytest.raises(kind) as error:
            engine.world.attach(name, link)
        assert named in str(error.value)
