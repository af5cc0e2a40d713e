"""Objects that are fixed to links while the simulation runs, and let go."""

from __future__ import annotations

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM, AWAY, HOME, point

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box
from tool0.description.transform import Pose, Transform
from tool0.errors import EngineError, ModelError

AT = (0.6, 0.1, 0.5)
"""In the air, in the robot's root, and clear of it [m]."""
GRAVITY = 9.8  # [m/s²]
CUBE = SceneObject(
    name="cube", geometry=Box(size=(0.04, 0.04, 0.04)), pose=Pose(xyz=AT), mass=0.5
)
STATUE = SceneObject(
    name="statue", geometry=CUBE.geometry, pose=Pose(xyz=(2.0, 0.0, 0.5))
)
LINK = "left_inner_finger_pad"  # fixed to a link that moves


def cube(robot: tool0.Robot) -> ObjectState:
    return next(o for o in robot.snapshot.objects if o.name == "cube")


def seen_from_link(robot: tool0.Robot, link: str = LINK) -> np.ndarray:
    """Return where the cube is in the link's frame [m]."""
    frame: Transform = robot.pose(link)
    w, x, y, z = frame.quat_wxyz
    away = np.subtract(cube(robot).position, frame.position)
    u = -np.array([x, y, z])  # the inverse turn
    turned = away + 2.0 * np.cross(u, np.cross(u, away) + w * away)
    return np.asarray(turned)


@pytest.fixture
def robot(bring_up: BringUp) -> tool0.Robot:
    return bring_up(scene=Scene((CUBE, STATUE)))


def test_it_moves_with_the_link_and_falls_when_let_go(robot: tool0.Robot) -> None:
    robot.engine.world.attach("cube", LINK)
    robot.run(0.001)
    assert cube(robot).position == pytest.approx(AT, abs=1e-5), "no jump"
    robot.run(0.5)
    held = seen_from_link(robot)
    robot.controller(ARM).follow([point(AWAY, 1.0)])
    robot.gripper.move(opening=0.02)
    worst = 0.0
    for _ in range(30):
        robot.run(0.05)
        worst = max(worst, np.linalg.norm(seen_from_link(robot) - held))
    assert worst < 5e-4
    robot.engine.world.detach("cube")
    robot.engine.world.detach("cube")
    before = cube(robot)
    robot.run(0.2)
    fallen = before.position[2] + before.linear[2] * 0.2 - cube(robot).position[2]
    assert fallen == pytest.approx(GRAVITY * 0.2**2 / 2, abs=5e-3)


def test_what_holds_it_is_told_with_the_contacts(robot: tool0.Robot) -> None:
    robot.engine.world.contacts()  # Gazebo looks from the first time on
    robot.engine.world.attach("cube", "tool0")
    robot.run(2.0)
    (contact,) = robot.contacts()
    assert (contact.first, contact.second) == ("tool0", "cube")
    weight = 0.5 * GRAVITY
    np.testing.assert_allclose(contact.force, (0.0, 0.0, weight), atol=0.01 * weight)
    np.testing.assert_allclose(contact.point, cube(robot).position, atol=1e-3)
    pull = np.array(robot.pose("tool0").rotation) @ robot.force_torque.read().raw_force
    gripper = 0.921 * GRAVITY
    assert pull[2] == pytest.approx(-weight - gripper, rel=0.01)


def test_what_cannot_be_attached_is_refused(robot: tool0.Robot) -> None:
    attach = robot.engine.world.attach
    with pytest.raises(ModelError) as unknown:
        attach("cube", "left_inner_fingr_pad")
    assert f"'{LINK}'" in str(unknown.value)
    attach("cube", "tool0")
    for name in ("cub", "statue", "cube"):
        with pytest.raises(EngineError) as error:
            attach(name, LINK)
        assert f"'{name}'" in str(error.value)
    robot.run(0.1)
    assert cube(robot).position[2] > AT[2] - 0.03, "the arm gives way a little"


def test_it_is_let_go_when_it_is_reset_placed_or_removed(robot: tool0.Robot) -> None:
    for way in ("reset", "placed", "removed"):
        robot.reset()
        robot.engine.world.attach("cube", "tool0")
        robot.controller(ARM).follow([point(HOME, 0.2)])
        robot.run(0.3)
        if way == "reset":
            robot.reset()
        elif way == "placed":
            robot.scene.place("cube", AT)
        else:
            robot.scene.remove("cube")
            robot.scene.add(CUBE)
        robot.engine.world.detach("cube")  # which is attached to nothing
        robot.run(0.2)
        assert cube(robot).linear[2] == pytest.approx(-GRAVITY * 0.2, abs=0.01)
    robot.engine.world.attach("cube", "base_link")  # which stands still
    robot.run(0.2)
    still = cube(robot)
    robot.run(0.2)
    assert cube(robot).position == pytest.approx(still.position, abs=1e-4)
