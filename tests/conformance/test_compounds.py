"""Bodies of several shapes: one body, which touches with each of its shapes."""

from __future__ import annotations

import pytest
from conformance_types import BringUp

from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box, Compound, Sphere
from tool0.description.transform import Pose

GROUND = -0.1  # [m], in the robot's root
GRAVITY = {"mujoco": 9.81, "gazebo": 9.8}  # [m/s²]
MASS, RADIUS, ARM = 2.0, 0.1, 0.4  # [kg, m, m] of a dumbbell along x
BALL = Sphere(radius=RADIUS)
DUMBBELL = Compound(
    parts=((BALL, Pose(xyz=(-ARM, 0.0, 0.0))), (BALL, Pose(xyz=(ARM, 0.0, 0.0))))
)
ANGLE = Compound(
    parts=(
        (Box(size=(0.3, 0.1, 0.1)), Pose(xyz=(0.15, 0.0, 0.05))),
        (Box(size=(0.1, 0.1, 0.2)), Pose(xyz=(0.05, 0.0, 0.2))),
    )
)
"""An L whose origin is its lower corner: 3 and 2 litres."""
ANGLE_CENTRE = 0.6 * 0.15 + 0.4 * 0.05  # [m] along x


def test_an_angle_falls_and_rests_on_its_long_side(
    bring_up: BringUp, engine: str
) -> None:
    angle = SceneObject(
        name="angle", geometry=ANGLE, pose=Pose(xyz=(1.5, 0.0, 0.0)), mass=1.5
    )
    robot = bring_up(scene=Scene((angle,)))
    robot.contacts()
    robot.run(1.5)
    state = robot.scene.states["angle"]
    assert state.position == pytest.approx((1.5, 0.0, GROUND), abs=5e-4)
    assert state.quat_wxyz == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-3)
    (contact,) = robot.contacts()
    assert {contact.first, contact.second} == {"angle", "ground"}
    weight = 1.5 * GRAVITY[engine]
    assert abs(contact.force[2]) == pytest.approx(weight, rel=0.01)
    assert contact.point[0] == pytest.approx(1.5 + ANGLE_CENTRE, abs=1e-3)
    robot.reset()
    assert robot.scene.states["angle"].position == pytest.approx((1.5, 0.0, 0.0))


def test_each_shape_touches_and_they_are_one_in_the_contacts(
    bring_up: BringUp, engine: str
) -> None:
    """A dumbbell across two posts; a gap between them is no part of it."""
    posts = tuple(
        SceneObject(
            name=name,
            geometry=Box(size=(0.2, 0.2, 0.3)),
            pose=Pose(xyz=(1.5 + x, 0.0, GROUND + 0.15)),
        )
        for name, x in (("left", -ARM), ("right", ARM))
    )
    at = Pose(xyz=(1.5, 0.0, GROUND + 0.3 + RADIUS))
    dumbbell = SceneObject(name="dumbbell", geometry=DUMBBELL, pose=at, mass=MASS)
    robot = bring_up(scene=Scene((*posts, dumbbell)))
    robot.contacts()
    robot.run(0.5)
    found = {
        c.first if c.second == "dumbbell" else c.second: c for c in robot.contacts()
    }
    assert set(found) == {"left", "right"}
    half = 0.5 * MASS * GRAVITY[engine]
    for name, x in (("left", 1.5 - ARM), ("right", 1.5 + ARM)):
        assert abs(found[name].force[2]) == pytest.approx(half, rel=0.01)
        assert found[name].point[0] == pytest.approx(x, abs=2e-3)
    robot.scene.place("dumbbell", (1.5, 1.0, GROUND + RADIUS))
    robot.run(0.5)
    (contact,) = robot.contacts()
    assert {contact.first, contact.second} == {"dumbbell", "ground"}
    assert abs(contact.force[2]) == pytest.approx(2.0 * half, rel=0.01)
    assert contact.point[0] == pytest.approx(1.5, abs=2e-3)


def test_a_dumbbell_turns_as_its_inertia_says(bring_up: BringUp) -> None:
    along, across = MASS * 0.4 * RADIUS**2, MASS * (0.4 * RADIUS**2 + ARM**2)
    high = Pose(xyz=(3.0, 0.0, 50.0))
    dumbbell = SceneObject(name="dumbbell", geometry=DUMBBELL, pose=high, mass=MASS)
    robot = bring_up(scene=Scene((dumbbell,)), paused=True)
    for axis, inertia in enumerate((along, across, across)):
        robot.reset()
        torque = [0.0, 0.0, 0.0]
        torque[axis] = 0.02
        robot.apply_wrench("dumbbell", torque=torque, duration=0.1)
        robot.step(200)
        expected = [0.0, 0.0, 0.0]
        expected[axis] = 0.02 * 0.1 / inertia
        angular = robot.scene.states["dumbbell"].angular
        assert angular == pytest.approx(expected, rel=1e-3, abs=1e-9)


def test_one_that_is_fixed_carries_and_is_put_elsewhere(bring_up: BringUp) -> None:
    """And one that comes later, while the first stays."""
    robot = bring_up()
    robot.scene.add("shelf", ANGLE, xyz=(1.5, 0.0, GROUND + 0.2))
    robot.scene.add("ball", BALL, xyz=(1.7, 0.0, GROUND + 0.31 + RADIUS), mass=0.5)
    robot.scene.place("ball", (1.55, 0.0, GROUND + 0.51 + RADIUS))
    robot.run(0.3)  # on the shorter leg
    assert robot.scene.pose("ball").position[2] == pytest.approx(
        GROUND + 0.5 + RADIUS, abs=1e-3
    )
    robot.scene.place("shelf", (3.0, 0.0, GROUND + 0.2))
    robot.run(0.5)
    assert robot.scene.pose("ball").position[2] == pytest.approx(
        GROUND + RADIUS, abs=1e-3
    )
