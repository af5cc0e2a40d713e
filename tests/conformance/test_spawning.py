"""Objects that come, go and are put somewhere while the simulation runs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM, ARM_JOINTS, AWAY, HOME, point

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box, Geometry, Mesh, Sphere
from tool0.description.transform import Pose
from tool0.errors import ConfigError, ControlError, EngineError, ModelError
from tool0.protocol.goals import GoalStatus

EDGE = 0.04  # [m]
GROUND = -0.1  # [m], in the robot's root
AWAY_FROM_ARM = (1.5, 0.0)  # [m]
GRAVITY = {"mujoco": 9.81, "gazebo": 9.8}  # [m/s^2]
NEAR = 1e-3
"""[m] of sinking into the ground, and of the error of a step's length."""


def thing(
    name: str = "cube",
    z: float = GROUND + EDGE / 2,
    *,
    x: float = AWAY_FROM_ARM[0],
    geometry: Geometry | None = None,
    mass: float | None = 0.1,
) -> SceneObject:
    return SceneObject(
        name=name,
        geometry=geometry or Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=(x, AWAY_FROM_ARM[1], z)),
        mass=mass,
    )


def state_of(robot: tool0.Robot, name: str) -> ObjectState:
    (found,) = [state for state in robot.snapshot.objects if state.name == name]
    return found


def names(robot: tool0.Robot) -> list[str]:
    named = [item.name for item in robot.scene.objects]
    assert named == [state.name for state in robot.snapshot.objects]
    return named


def test_an_object_that_comes_disturbs_nothing_else(bring_up: BringUp) -> None:
    robot, alone = bring_up(scene=Scene((thing("first", 0.4, x=2.0),))), bring_up()
    for each in (robot, alone):
        each.controller(ARM).follow([point(AWAY, 1.0)])
        each.run(0.3)
    before = robot.snapshot
    robot.scene.add(thing("second", 0.3))
    after = robot.snapshot
    assert after.time == before.time
    assert after.position == before.position
    assert after.velocity == before.velocity
    assert after.objects[0] == before.objects[0]
    assert names(robot) == ["first", "second"]
    assert after.objects[1].position == pytest.approx((*AWAY_FROM_ARM, 0.3), abs=1e-12)
    for each in (robot, alone):
        each.run(1.0)
    np.testing.assert_allclose(
        robot.snapshot.position, alone.snapshot.position, atol=1e-4
    )


def test_what_comes_falls_and_comes_to_rest(bring_up: BringUp, engine: str) -> None:
    robot = bring_up()
    robot.run(0.1)
    robot.scene.add(thing(z=0.5))
    assert state_of(robot, "cube").linear == (0.0, 0.0, 0.0)
    robot.run(0.2)
    falling = state_of(robot, "cube")
    pull = GRAVITY[engine]
    assert falling.linear == pytest.approx((0.0, 0.0, -pull * 0.2), abs=1e-3)
    assert falling.position[2] == pytest.approx(0.5 - pull * 0.2**2 / 2, abs=2e-3)
    robot.run(1.5)
    resting = state_of(robot, "cube")
    assert resting.position[2] == pytest.approx(GROUND + EDGE / 2, abs=NEAR)
    assert math.hypot(*resting.linear) < NEAR


def test_what_has_no_mass_stands_and_carries(bring_up: BringUp) -> None:
    robot = bring_up(scene=Scene((thing(z=0.25),)))
    table = thing("table", 0.18, geometry=Box(size=(0.4, 0.4, 0.04)), mass=None)
    robot.scene.add(table)
    robot.run(0.5)
    assert state_of(robot, "cube").position[2] == pytest.approx(0.22, abs=NEAR)
    assert state_of(robot, "table").position == pytest.approx(table.pose.xyz)
    robot.scene.place("table", (*AWAY_FROM_ARM, 0.08))
    robot.run(0.5)
    assert state_of(robot, "cube").position[2] == pytest.approx(0.12, abs=NEAR)
    robot.scene.remove("table")
    assert names(robot) == ["cube"]
    robot.run(0.5)
    assert state_of(robot, "cube").position[2] < 0.0


def test_what_is_placed_moves_as_it_is_told(bring_up: BringUp, engine: str) -> None:
    robot = bring_up()
    robot.scene.add(thing())
    robot.run(0.1)
    half = 0.35  # [rad]
    turned = (math.cos(half), math.sin(half), 0.0, 0.0)
    robot.scene.place(
        "cube", (1.0, 0.5, 0.5), turned, linear=(0.3, -0.2, 1.0), angular=(0, 0, 2.0)
    )
    placed = state_of(robot, "cube")
    assert placed.position == pytest.approx((1.0, 0.5, 0.5), abs=1e-9)
    assert placed.quat_wxyz == pytest.approx(turned, abs=1e-9)
    assert placed.linear == pytest.approx((0.3, -0.2, 1.0), abs=1e-9)
    assert placed.angular == pytest.approx((0.0, 0.0, 2.0), abs=1e-9)
    t = 0.2
    robot.run(t)
    flying = state_of(robot, "cube")
    fall = GRAVITY[engine] * t
    assert flying.linear == pytest.approx((0.3, -0.2, 1.0 - fall), abs=NEAR)
    assert flying.angular == pytest.approx((0.0, 0.0, 2.0), abs=NEAR)
    where = (1.0 + 0.3 * t, 0.5 - 0.2 * t, 0.5 + t - fall * t / 2)
    assert flying.position == pytest.approx(where, abs=2e-3)
    # turned about the root's z by 2 rad/s, after it had been turned about x
    cos, sin = math.cos(t), math.sin(t)
    c, s = turned[:2]
    assert flying.quat_wxyz == pytest.approx(
        (cos * c, cos * s, sin * s, sin * c), abs=NEAR
    )


def test_what_went_can_come_again_as_something_else(bring_up: BringUp) -> None:
    robot = bring_up(scene=Scene((thing("stays", x=2.0),)))
    robot.scene.add(thing())
    robot.run(0.1)
    robot.scene.remove("cube")
    assert names(robot) == ["stays"]
    ball = thing(geometry=Sphere(radius=0.03), z=GROUND + 0.03)
    robot.scene.add(ball)
    assert robot.scene.objects[1] == ball
    robot.run(0.5)
    assert state_of(robot, "cube").position[2] == pytest.approx(GROUND + 0.03, abs=NEAR)
    robot.scene.remove("stays")
    robot.scene.remove("cube")
    assert names(robot) == []
    robot.run(0.1)


def test_a_refusal_changes_nothing(bring_up: BringUp, tmp_path: Path) -> None:
    robot = bring_up(scene=Scene((thing(),)))
    robot.run(0.1)
    before, objects = robot.snapshot, robot.scene.objects
    broken = tmp_path / "broken.stl"
    broken.write_bytes(b"no mesh")
    mesh = Mesh(uri="broken.stl", path=broken)
    add, remove, place = robot.scene.add, robot.scene.remove, robot.scene.place
    for refused, kind, name in (
        (lambda: add(thing()), EngineError, "'cube'"),
        (lambda: add(thing("tool0")), ConfigError, "'tool0'"),
        (lambda: add(thing("part", geometry=mesh)), (ModelError, EngineError), "part"),
        (lambda: remove("cubes"), EngineError, "'cubes'"),
        (lambda: place("cubes", (0.0, 0.0, 1.0)), EngineError, "'cubes'"),
    ):
        with pytest.raises(kind) as error:
            refused()
        assert name in str(error.value)
    for wrong in ({"position": (1.0, 2.0)}, {"quat_wxyz": (0.0, 0.0, 0.0, 0.0)}):
        with pytest.raises(ControlError):
            robot.scene.place("cube", **{"position": (0.0, 0.0, 1.0), **wrong})  # type: ignore[arg-type]
    after = robot.snapshot
    assert after.objects == before.objects
    assert after.scene is before.scene
    assert robot.scene.objects is objects
    robot.run(0.1)
    assert state_of(robot, "cube").position == pytest.approx(
        before.objects[0].position, abs=NEAR
    )


def test_what_stands_still_cannot_be_placed_moving(bring_up: BringUp) -> None:
    robot = bring_up(scene=Scene((thing("post", mass=None),)))
    with pytest.raises(EngineError):
        robot.scene.place("post", (1.0, 1.0, 0.0), linear=(0.1, 0.0, 0.0))


def test_a_reset_puts_back_what_came_later_and_what_was_placed(
    bring_up: BringUp,
) -> None:
    post = thing("post", 0.0, x=2.0, mass=None)
    robot = bring_up(scene=Scene((post,)))
    robot.run(0.1)
    robot.scene.add(thing(z=0.5))
    before = robot.snapshot.objects
    robot.run(0.2)
    robot.scene.place("cube", (1.0, 1.0, 1.0), linear=(1.0, 0.0, 0.0))
    robot.scene.place("post", (2.0, 1.0, 0.0))
    robot.reset()
    assert robot.time == robot.snapshot.time == 0.0
    assert names(robot) == ["post", "cube"]
    for was, now in zip(before, robot.snapshot.objects, strict=True):
        assert now.position == pytest.approx(was.position, abs=1e-12)
        assert now.linear == now.angular == (0.0, 0.0, 0.0)
    robot.scene.remove("cube")
    robot.reset()
    assert names(robot) == ["post"]


def test_a_reset_can_let_time_go_on(bring_up: BringUp) -> None:
    robot = bring_up(scene=Scene((thing(z=0.5),)))
    goal = robot.controller(ARM).follow([point(AWAY, 1.0)])
    robot.run(0.4)
    robot.reset(keep_time=True)
    assert goal.status is GoalStatus.PREEMPTED
    assert robot.time == robot.snapshot.time == pytest.approx(0.4)
    assert robot.engine.read().time == pytest.approx(0.4)
    assert state_of(robot, "cube").position[2] == pytest.approx(0.5)
    joints = robot.joint_state.position
    start = [joints[name] for name in ARM_JOINTS]
    np.testing.assert_allclose(start, HOME, atol=1e-4)
    robot.controller(ARM).follow([point(AWAY, 0.5)])  # in the time that goes on
    robot.run(1.0)
    joints = robot.joint_state.position
    np.testing.assert_allclose([joints[name] for name in ARM_JOINTS], AWAY, atol=0.03)
    assert robot.time == robot.snapshot.time == pytest.approx(1.4)
    robot.reset()
    assert robot.time == 0.0


def test_the_same_commands_give_the_same_bits(bring_up: BringUp) -> None:
    def run(robot: tool0.Robot) -> list[object]:
        seen: list[object] = []

        def go_on() -> None:
            robot.run(0.111)
            now = robot.snapshot
            seen.append((now.time, now.position, now.velocity, now.objects))

        robot.controller(ARM).follow([point(AWAY, 0.5)])
        go_on()
        robot.scene.add(thing(z=0.0))
        robot.scene.add(thing("other", 0.06))
        go_on()
        robot.scene.place("other", (1.5, 0.01, 0.1), linear=(0.0, 0.0, -1.0))
        go_on()
        robot.scene.add(thing("third", 0.3))
        go_on()
        robot.scene.remove("cube")
        go_on()
        robot.reset(keep_time=True)
        go_on()
        return seen

    assert run(bring_up()) == run(bring_up())
