"""What touches what, and how hard."""

from __future__ import annotations

import numpy as np
import pytest

import tool0
from tool0.description.catalogue import assemble, named_poses
from tool0.description.kinematics import link_pose
from tool0.description.model import Box, Cylinder, Pose, RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.hardware.engine import Contact
from tool0.sensing.pads import grasp_frame, pad_links

REST = [0.0, 0.0, 0.0, 0.2]  # the skew robot's joints
FAR = 5.0  # [m] from the robot, which lies about
EDGE = 0.04  # [m]
WEIGHT = 0.1 * 9.81  # [N]


def cube(name: str, *, x: float = FAR, z: float = EDGE / 2) -> SceneObject:
    return SceneObject(
        name=name,
        geometry=Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=(x, 0.0, z)),
        mass=0.1,
    )


def let_pass(engine: MujocoEngine, duration: float) -> None:
    for _ in range(round(duration / engine.dt)):
        engine.step()


def on(contacts: tuple[Contact, ...], name: str, by: str) -> Contact:
    """Return what ``by`` does to ``name``, whichever comes first."""
    (contact,) = [c for c in contacts if {c.first, c.second} == {name, by}]
    if contact.second == name:
        return contact
    x, y, z = contact.force
    a, b, c = contact.torque
    return Contact(by, name, contact.point, (-x, -y, -z), (-a, -b, -c))


def test_a_box_at_rest_presses_on_the_ground_with_its_weight(
    skew_model: RobotModel,
) -> None:
    engine = MujocoEngine(
        skew_model, scene=Scene((cube("low"), cube("high", z=1.5 * EDGE)))
    )
    engine.reset(REST)
    let_pass(engine, 1.0)
    below = on(engine.world.contacts(), "low", by="ground")
    between = on(engine.world.contacts(), "high", by="low")
    np.testing.assert_allclose(below.force, [0, 0, 2 * WEIGHT], atol=0.02 * WEIGHT)
    np.testing.assert_allclose(between.force, [0, 0, WEIGHT], atol=0.01 * WEIGHT)
    np.testing.assert_allclose(below.point, [FAR, 0, 0], atol=1e-4)
    np.testing.assert_allclose(between.point, [FAR, 0, EDGE], atol=1e-4)
    np.testing.assert_allclose(between.torque, 0, atol=1e-4)


def test_before_the_first_step_nothing_presses(skew_model: RobotModel) -> None:
    engine = MujocoEngine(skew_model, scene=Scene((cube("low"),)))
    engine.reset(REST)
    assert engine.world.contacts() == ()
    let_pass(engine, 0.1)
    assert engine.world.contacts()
    engine.reset(REST)
    assert engine.world.contacts() == ()


def test_who_comes_or_goes_changes_nothing_about_the_last_step(
    skew_model: RobotModel,
) -> None:
    engine = MujocoEngine(skew_model, scene=Scene((cube("low"),)))
    engine.reset(REST)
    let_pass(engine, 0.5)
    before = engine.world.contacts()
    engine.world.spawn(cube("other", x=2 * FAR))
    assert engine.world.contacts() == before
    let_pass(engine, 0.5)
    assert len(engine.world.contacts()) == 2


@pytest.mark.parametrize("force", [20.0, 100.0])
def test_pads_press_on_a_can_with_the_force_of_the_drive(force: float) -> None:
    width, height = 0.05, 0.02  # [m]
    description = assemble()
    (gripper,) = description.model.grippers
    tool = description.model.joint(gripper.joint).parent
    grasp = grasp_frame(description.model, gripper, width, tool)
    home = link_pose(description.model, named_poses(description)["home"], tool)
    x, y, z = (home @ grasp).position
    post = SceneObject(
        name="post",
        geometry=Cylinder(radius=0.01, length=height),
        pose=Pose(xyz=(x, y, z - height)),
    )
    can = SceneObject(
        name="can",
        geometry=Cylinder(radius=width / 2, length=height),
        pose=Pose(xyz=(x, y, z)),
        mass=0.1,
    )
    with tool0.bringup(realtime=False, scene=Scene((post, can))) as robot:
        lever = gripper.lever(gripper.position(width))
        robot.gripper.move(opening=0.0, effort=force * lever)
        robot.run(2.0)
        for pad in pad_links(description.model, gripper):
            contact = on(robot.contacts(), "can", by=pad)
            assert np.linalg.norm(contact.force) == pytest.approx(force, rel=0.05)
            inwards = robot.snapshot.objects[1].position - np.array(contact.point)
            assert contact.force @ inwards > 0.9 * force * width / 2
