"""What presses on what, and how hard, told by both engines in the same names."""

from __future__ import annotations

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM_JOINTS

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import Contact
from tool0.description.shapes import Box, Sphere
from tool0.description.transform import Pose

EDGE = 0.04  # [m]
GROUND = -0.1  # [m], in the robot's root
GRAVITY = {"mujoco": 9.81, "gazebo": 9.8}  # [m/s²]
PADS = ("left_inner_finger_pad", "right_inner_finger_pad")


def box(
    name: str, x: float, z: float, mass: float | None, edges: tuple[float, ...] = ()
) -> SceneObject:
    a, b, c = edges or (EDGE, EDGE, EDGE)
    shape = Box(size=(a, b, c))
    return SceneObject(name=name, geometry=shape, pose=Pose(xyz=(x, 0.3, z)), mass=mass)


TABLE = box("table", 1.0, 0.1, None, (0.3, 0.3, 0.04))


def between(robot: tool0.Robot, first: str, second: str) -> Contact:
    """Return what the first does to the second, whichever way it is told."""
    (found,) = [c for c in robot.contacts() if {c.first, c.second} == {first, second}]
    if found.first == first:
        return found
    force, torque = np.negative(found.force), np.negative(found.torque)
    return Contact(first, second, found.point, tuple(force), tuple(torque))


def touched(robot: tool0.Robot, *links: str) -> bool:
    """Return whether the engine finds one of ``links`` in a contact."""
    simulation = robot.simulation
    world = simulation.engine.world
    return simulation.loop.call(lambda: world.is_touched(frozenset(links)))


def test_what_lies_presses_with_its_weight(bring_up: BringUp, engine: str) -> None:
    low = box("low", 1.5, GROUND + EDGE / 2, 1.0)
    robot = bring_up(scene=Scene((TABLE, box("cube", 1.0, 0.14, 0.5), low)))
    assert robot.contacts() == ()
    robot.run(1.0)
    for _ in range(2):  # the second time ODE has put them to sleep
        for below, name, mass, x, z in (
            ("table", "cube", 0.5, 1.0, 0.12),
            ("ground", "low", 1.0, 1.5, GROUND),
        ):
            contact = between(robot, below, name)
            weight = mass * GRAVITY[engine]
            assert contact.force == pytest.approx((0.0, 0.0, weight), abs=0.01 * weight)
            assert contact.torque == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)
            assert contact.point == pytest.approx((x, 0.3, z), abs=2e-4)
        assert len(robot.contacts()) == 2
        assert robot.contacts() == robot.contacts()
        robot.run(3.0)
    robot.scene.remove("cube")
    robot.run(0.01)
    assert [{c.first, c.second} for c in robot.contacts()] == [{"ground", "low"}]
    robot.reset()
    assert robot.contacts() == ()


def test_a_weight_beside_the_middle_is_felt_there(
    bring_up: BringUp, engine: str
) -> None:
    """On a box that carries a second one near its edge."""
    lower = box("lower", 1.0, 0.14, 1.0, (0.1, 0.1, 0.04))
    upper = box("upper", 1.03, 0.18, 1.0)
    robot = bring_up(scene=Scene((TABLE, lower, upper)))
    robot.contacts()
    robot.run(1.0)
    carried = between(robot, "table", "lower")
    weight = 2.0 * GRAVITY[engine]
    assert carried.force == pytest.approx((0.0, 0.0, weight), abs=0.01 * weight)
    assert carried.point == pytest.approx((1.015, 0.3, 0.12), abs=5e-4)
    on_top = between(robot, "upper", "lower")
    assert on_top.force[2] == pytest.approx(-0.5 * weight, rel=0.01)
    assert on_top.point[:2] == pytest.approx((1.03, 0.3), abs=5e-4)


def test_pads_press_as_hard_as_the_drive_is_set(bring_up: BringUp) -> None:
    robot = bring_up(initial_pose="ready")
    robot.contacts()
    robot.gripper.move(opening=EDGE).wait(5.0)
    robot.run(0.5)
    x, y, z = np.mean([robot.pose(pad).position for pad in PADS], axis=0).tolist()
    block = SceneObject(
        name="block",
        geometry=Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=(x, y, z)),
        friction=0.0,  # pads that swing would carry some of the force by friction
    )
    robot.gripper.move(opening=0.05).wait(5.0)
    robot.scene.add(block)
    for force in (20.0, 235.0):  # test_grip_forces.py has the rest
        robot.gripper.move(opening=0.05).wait(5.0)
        assert robot.contacts() == ()
        assert not touched(robot, *PADS)
        robot.gripper.move(opening=0.0, force=force)
        robot.run(1.0)
        assert touched(robot, "forearm_link", PADS[0])
        assert not touched(robot, "forearm_link", "wrist_3_link")
        pressing = [between(robot, pad, "block") for pad in PADS]
        # What the arm adds on one side, as it does not stand in the very middle, is
        # missing on the other.
        left, right = (np.linalg.norm(contact.force) for contact in pressing)
        assert (left + right) / 2.0 == pytest.approx(force, rel=0.1)
        one, other = (robot.pose(pad).position for pad in PADS)
        towards = np.subtract(other, one)
        along = [np.dot(contact.force, towards) for contact in pressing]
        assert along[1] < 0.0 < along[0], "each pushes towards the other"


def test_a_robot_that_touches_nothing_tells_of_nothing(bring_up: BringUp) -> None:
    robot = bring_up()
    robot.contacts()
    robot.move_joints({name: 0.1 for name in ARM_JOINTS[4:]}, speed=1.0)
    for _ in range(5):
        robot.run(0.1)
        assert robot.contacts() == ()


@pytest.mark.parametrize("spawn_z", [0.1, 0.6])
def test_the_pedestal_stands_on_the_ground_and_bumps(
    bring_up: BringUp, spawn_z: float
) -> None:
    ball = SceneObject(
        name="ball",
        geometry=Sphere(radius=0.04),
        pose=Pose(xyz=(-0.3, 0.0, 0.041 - spawn_z)),
        mass=0.1,
    )
    robot = bring_up(scene=Scene((ball,)), spawn_z=spawn_z)
    assert robot.contacts() == ()
    robot.run(0.1)
    assert [{c.first, c.second} for c in robot.contacts()] == [{"ground", "ball"}]
    robot.scene.place("ball", (-0.2, 0.0, 0.06 - spawn_z), linear=(1.0, 0.0, 0.0))
    met = set()
    for _ in range(100):
        robot.run(0.002)
        met |= {name for c in robot.contacts() for name in (c.first, c.second)}
    assert met - {"ground"} == {"ball", "pedestal"}
    assert robot.scene.pose("ball").position[0] < -0.11
