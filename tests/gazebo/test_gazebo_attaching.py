"""Objects that are attached in Gazebo, often, and while others delete them."""

from __future__ import annotations

import pytest
from in_gazebo import BringUp, gz

from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose

CUBE = SceneObject(
    name="cube",
    geometry=Box(size=(0.04, 0.04, 0.04)),
    pose=Pose(xyz=(0.6, 0.1, 0.5)),
    mass=0.1,
)


def test_fifty_times_attached_and_let_go(bring_up: BringUp) -> None:
    robot, engine = bring_up(scene=Scene((CUBE,)))
    for _ in range(50):
        engine.world.attach("cube", "left_inner_finger_pad")
        robot.run(0.004)
        engine.world.detach("cube")
        robot.run(0.001)
    fallen = CUBE.pose.xyz[2] - robot.snapshot.objects[0].position[2]
    assert 0.0 < fallen < 0.1
    for _ in range(5):
        engine.world.attach("cube", "tool0")
        robot.run(0.01)
        robot.scene.remove("cube")
        robot.run(0.01)
        robot.scene.add(CUBE)
        robot.run(0.01)
    robot.reset()
    robot.run(0.1)
    (cube,) = robot.snapshot.objects
    assert cube.linear[2] == pytest.approx(-0.98, abs=0.01)


def test_what_somebody_else_deleted_while_it_touched_and_was_attached(
    bring_up: BringUp,
) -> None:
    table = SceneObject(
        name="table",
        geometry=Box(size=(0.3, 0.3, 0.04)),
        pose=Pose(xyz=(0.6, 0.1, 0.46)),
    )
    robot, engine = bring_up(scene=Scene((table, CUBE)), allow_penetration=True)
    robot.contacts()
    robot.run(0.1)
    assert robot.contacts()
    engine.world.attach("cube", "tool0")
    gz(engine, "model", "-m", "cube", "-d")
    gz(engine, "model", "-m", "table", "-d")
    for _ in range(3):
        robot.contacts()
        robot.run(0.5)
    assert robot.contacts() == ()
    robot.scene.remove("cube")
    robot.scene.add(CUBE)
    engine.world.attach("cube", "tool0")
    robot.run(0.1)
    engine.world.detach("cube")
    robot.run(0.1)
    assert robot.snapshot.objects[1].linear[2] < -0.9
