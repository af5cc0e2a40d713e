"""Wrenches that are applied to links and objects, for a span of simulated time."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import HOME

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import EngineError, RequestError

MASS, EDGE = 2.0, 0.3  # [kg, m]
INERTIA = MASS * EDGE * EDGE / 6.0
FALLING = (3.0, 0.0, 50.0)  # [m], where nothing is met for a second
CUBE = SceneObject(
    name="cube",
    geometry=Box(size=(EDGE, EDGE, EDGE)),
    pose=Pose(xyz=FALLING),
    mass=MASS,
)
WALL = SceneObject(
    name="wall", geometry=Box(size=(0.1, 0.1, 0.1)), pose=Pose(xyz=(-3.0, 0.0, 1.0))
)
SCENE = Scene((CUBE, WALL))


@pytest.fixture(scope="module")
def shared_cell(engine: str) -> Iterator[tool0.Robot]:
    simulation = tool0.SimulationConfig(engine=engine)
    with tool0.bringup(
        scene=SCENE, simulation=simulation, paused=True, realtime=False
    ) as robot:
        yield robot


@pytest.fixture
def robot(shared_cell: tool0.Robot) -> tool0.Robot:
    """Return the robot with a cube and a wall, as if just brought up, and paused."""
    shared_cell.reset()
    return shared_cell


def cube(robot: tool0.Robot) -> ObjectState:
    return robot.scene.states["cube"]


def test_a_force_accelerates_for_as_long_as_it_acts(robot: tool0.Robot) -> None:
    robot.apply_wrench("cube", force=(6.0, -4.0, 0.0), duration=0.1)
    robot.step(50)
    assert cube(robot).linear[:2] == pytest.approx((0.15, -0.1), rel=1e-6)
    robot.step(150)
    assert cube(robot).linear[:2] == pytest.approx((0.3, -0.2), rel=1e-6)
    assert cube(robot).angular == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_a_torque_turns_it(robot: tool0.Robot) -> None:
    robot.apply_wrench("cube", torque=(0.0, 0.0, 0.3), duration=0.1)
    robot.step(200)
    expected = 0.3 * 0.1 / INERTIA
    assert cube(robot).angular == pytest.approx((0.0, 0.0, expected), rel=1e-5)


def test_a_force_beside_the_centre_of_mass_turns_it_too(robot: tool0.Robot) -> None:
    x, y, z = FALLING
    robot.apply_wrench(
        "cube", force=(0.0, 3.0, 0.0), point=(x + 0.1, y, z), duration=0.05
    )
    robot.step(100)
    assert cube(robot).linear[1] == pytest.approx(3.0 * 0.05 / MASS, rel=1e-5)
    expected = 0.1 * 3.0 * 0.05 / INERTIA
    assert cube(robot).angular[2] == pytest.approx(expected, rel=1e-4)


def test_wrenches_add_up_until_they_are_cleared(robot: tool0.Robot) -> None:
    for _ in range(2):
        robot.apply_wrench("cube", force=(1.0, 0.0, 0.0))
    robot.step(100)
    robot.clear_wrenches("cube")
    robot.step(100)
    assert cube(robot).linear[0] == pytest.approx(0.1, rel=1e-6)
    robot.apply_wrench("cube", force=(1.0, 0.0, 0.0))
    robot.step(1)
    robot.reset()
    robot.step(100)
    assert cube(robot).linear[0] == 0.0


def test_it_survives_that_other_objects_come_and_go(bring_up: BringUp) -> None:
    robot = bring_up(scene=SCENE, paused=True)
    robot.apply_wrench("cube", force=(2.0, 0.0, 0.0))
    robot.step(50)
    robot.scene.add("other", Box(size=(0.1, 0.1, 0.1)), xyz=(5.0, 5.0, 0.5), mass=1.0)
    robot.apply_wrench("other", force=(0.0, 0.0, 1.0))
    robot.step(50)
    robot.scene.remove("other")
    robot.step(100)
    assert cube(robot).linear[0] == pytest.approx(0.2, rel=1e-6)


def test_a_link_is_pushed_and_swings_back(bring_up: BringUp) -> None:
    robot = bring_up()
    robot.run(0.5)
    before = robot.pose("tool0").position
    robot.apply_wrench("wrist_3_link", force=(0.0, 100.0, 0.0), duration=0.05)
    robot.run(0.05)
    assert robot.pose("tool0").position[1] - before[1] > 1e-4
    robot.run(3.0)
    np.testing.assert_allclose(robot.pose("tool0").position, before, atol=2e-3)


def test_the_wrist_feels_what_pushes_the_tool(bring_up: BringUp) -> None:
    """As if a hand pressed on the gripper: that is no acceleration of its own."""
    robot = bring_up()
    robot.run(1.0)
    robot.force_torque.zero()
    pushed = np.array([0.0, 0.0, 20.0])
    robot.apply_wrench("robotiq_arg2f_base_link", force=pushed.tolist())
    robot.run(2.0)
    felt = robot.force_torque.read()
    frame = robot.pose(felt.frame)
    np.testing.assert_allclose(frame.rotate(felt.force), pushed, atol=0.2)


@pytest.mark.parametrize(
    ("name", "says"),
    [("cub", "did you mean 'cube'"), ("wall", "is fixed"), ("base_link", "is fixed")],
)
def test_what_cannot_be_pushed_is_refused(
    robot: tool0.Robot, name: str, says: str
) -> None:
    with pytest.raises(EngineError, match=says):
        robot.apply_wrench(name, force=(1.0, 0.0, 0.0))
    with pytest.raises(RequestError):
        robot.apply_wrench("cube", force=(math.nan, 0.0, 0.0))
    robot.step(10)
    assert cube(robot).linear[0] == 0.0
    assert robot.snapshot.position[0] == pytest.approx(HOME[0], abs=1e-3)
