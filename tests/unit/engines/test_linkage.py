"""The 2F-85's fingers in MuJoCo: those that mimic, and those that wrap around."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path

import numpy as np
import pytest
from hand_rig import DOWN, LEVEL, ON_ITS_SIDE, SIDES, UP, Hand, hand_model

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder
from tool0.description.transform import Pose
from tool0.errors import DivergenceError
from tool0.hardware.engine import LARGEST_VELOCITY

pytestmark = pytest.mark.slow

CLOSED = 0.8133  # [rad]
FAST = 0.15  # [m/s], between the pads
PIN = "{}_outer_finger_joint"
SLIPPERY = 0.1


def can(radius: float, depth: float, *, mass: float, friction: float) -> SceneObject:
    """Return a can across a hand that points down, ``depth`` below the hand's foot."""
    return SceneObject(
        name="can",
        geometry=Cylinder(radius=radius, length=0.06),
        pose=Pose(xyz=(0.0, 0.0, -depth), rpy=(0.0, math.pi / 2, 0.0)),
        mass=mass,
        friction=friction,
    )


def stands(radius: float, depth: float) -> list[SceneObject]:
    """Return what such a can lies on, out of the fingers' way."""
    height = 0.02
    return [
        SceneObject(
            name=f"stand {x}",
            geometry=Box(size=(0.012, 0.01, height)),
            pose=Pose(xyz=(x, 0.0, -depth - radius - height / 2)),
        )
        for x in (-0.023, 0.023)
    ]


def cube(edge: float, height: float) -> SceneObject:
    """Return a cube that stands on a thin plate, in a hand that points up."""
    return SceneObject(
        name="cube",
        geometry=Box(size=(edge, edge, edge)),
        pose=Pose(xyz=(0.0, 0.0, height)),
        mass=0.1,
    )


def sweep(hand: Hand, target: float) -> None:
    """Let the pads go at full speed to the angle ``target``, measuring on the way."""
    angle, goal = hand.angle, target
    while abs(goal - angle) > 1e-3:
        rate = math.copysign(FAST / hand.geometry.lever(angle), goal - angle)
        angle += rate * hand.engine.dt
        hand.hold(angle, rate)
        assert hand.opening() == pytest.approx(
            hand.geometry.opening(hand.angle), abs=5e-4
        )
        assert hand.skew() <= 1.0


@pytest.mark.parametrize("rpy", [UP, DOWN, LEVEL, ON_ITS_SIDE])
@pytest.mark.parametrize("gripper_model", ["mimic", "linkage"])
def test_free_pads_are_parallel_and_open_as_the_formula_says(
    tmp_path: Path, gripper_model: str, rpy: str
) -> None:
    hand = Hand(hand_model(tmp_path, gripper_model, rpy))
    for target in (CLOSED - 0.01, 0.0, 0.4):
        sweep(hand, target)
        velocities = []
        for k in range(700):
            hand.hold(target)
            if k >= 400:
                velocities.append(hand.state.velocity)
        assert np.sqrt(np.mean(np.square(velocities), axis=0)).max() <= 1e-4
        assert hand.opening() == pytest.approx(hand.geometry.opening(target), abs=1e-4)
        assert hand.skew() <= 0.1


@pytest.mark.parametrize("force", [20.0, 60.0, 120.0, 235.0])
def test_the_linkage_pinches_in_parallel_with_the_force_it_is_told(
    tmp_path: Path, force: float
) -> None:
    height = 0.1418  # where the pads meet it
    plate = SceneObject(
        name="plate",
        geometry=Box(size=(0.02, 0.02, 0.01)),
        pose=Pose(xyz=(0.0, 0.0, height - 0.045 / 2 - 0.005)),
    )
    hand = Hand(hand_model(tmp_path, "linkage"), plate, cube(0.045, height))
    hand.squeeze(force, 1.0)
    assert hand.skew() <= 2.0
    for side in SIDES:
        assert hand.press(side, "cube") == pytest.approx(force, rel=0.1)
        assert abs(hand.joint(PIN.format(side))) <= math.radians(1.0)
        assert hand.gap(f"{side}_loop_joint") <= 2e-4


@pytest.mark.parametrize(("radius", "depth"), [(0.030, 0.115), (0.0225, 0.109)])
def test_the_linkage_wraps_around_what_lies_deep_and_holds_it(
    tmp_path: Path, radius: float, depth: float
) -> None:
    hand = Hand(
        hand_model(tmp_path, "linkage", DOWN),
        *stands(radius, depth),
        can(radius, depth, mass=2.0, friction=SLIPPERY),
    )
    hand.squeeze(60.0, 1.2)
    for side in SIDES:
        assert hand.joint(PIN.format(side)) < -math.radians(5.0)
        across, along = hand.tip(side)[1:] - hand.place("can")[1:]
        assert abs(across) < radius - 0.005  # behind it:
        assert along < -0.5 * radius
        assert hand.gap(f"{side}_loop_joint") <= 2e-4
    let_go(hand)
    hand.squeeze(60.0, 1.0)
    assert hand.place("can")[2] == pytest.approx(-depth, abs=0.003)


def test_a_pinch_of_that_force_lets_it_slip(tmp_path: Path) -> None:
    depth = 0.139  # the middle of the pads
    hand = Hand(
        hand_model(tmp_path, "linkage", DOWN),
        *stands(0.03, depth),
        can(0.03, depth, mass=2.0, friction=SLIPPERY),
    )
    hand.squeeze(60.0, 1.2)
    for side in SIDES:
        assert hand.press(side, "can") == pytest.approx(60.0, rel=0.1)
    let_go(hand)
    hand.squeeze(60.0, 0.5)
    assert hand.place("can")[2] < -depth - 0.1


def test_no_force_flips_the_linkage_over(tmp_path: Path) -> None:
    wedge = SceneObject(  # holds the inner knuckles apart; it stands still
        name="wedge",
        geometry=Cylinder(radius=0.026, length=0.06),
        pose=Pose(xyz=(0.0, 0.0, 0.095), rpy=(0.0, math.pi / 2, 0.0)),
    )
    hand = Hand(hand_model(tmp_path, "linkage"), wedge)
    hand.squeeze(235.0, 1.5)
    for side in SIDES:
        assert 0.5 < hand.joint(f"{side}_inner_finger_joint") < 0.95
        assert hand.gap(f"{side}_loop_joint") <= 5e-4
    for _ in range(1000):
        hand.hold(0.0)
    assert hand.opening() == pytest.approx(hand.geometry.opening(0.0), abs=5e-4)
    assert hand.skew() <= 1.0


def let_go(hand: Hand) -> None:
    """Take the stands away: from now on the can's weight pulls it out."""
    for item in hand.engine.world.object_states():
        if item.name.startswith("stand"):
            hand.engine.world.delete(item.name)


@pytest.mark.parametrize("rpy", [UP, DOWN, LEVEL])
@pytest.mark.parametrize("gripper_model", ["mimic", "linkage"])
def test_the_drive_carries_the_fingers_and_their_springs(
    tmp_path: Path, gripper_model: str, rpy: str
) -> None:
    hand = Hand(hand_model(tmp_path, gripper_model, rpy))
    for angle in (0.2, 0.6):
        for _ in range(800):
            hand.hold(angle)
        for _ in range(300):
            hand.drive(0.0)
        assert hand.angle == pytest.approx(angle, abs=1e-3)


@pytest.mark.parametrize("lift", [0.2, 0.9])
def test_no_snapshot_of_a_start_in_the_ground_is_absurd(lift: float) -> None:
    with tool0.bringup(
        realtime=False,
        initial_pose={"shoulder_lift_joint": lift, "elbow_joint": 0.5},
        simulation=tool0.SimulationConfig(allow_penetration=True),
        description=tool0.DescriptionConfig(gripper_model="linkage"),
    ) as robot:
        subscription = robot.subscribe(500.0)
        with contextlib.suppress(DivergenceError):
            robot.run(0.3)
        values = [
            value
            for snapshot in subscription.pending()
            for value in (*snapshot.position, *snapshot.velocity)
        ]
        assert max(map(abs, values)) < LARGEST_VELOCITY
