"""The wrench at the wrist: weight, what is held, what is pressed on, and motion."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM, BETWEEN_PADS, EDGE, HOME, TABLE, point

import tool0
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose, to_transform

ABOVE_TABLE = {
    "shoulder_lift_joint": -1.2,
    "elbow_joint": 1.9,
    "wrist_1_joint": -2.2708,
}
WRISTS = [(-1.5708, -1.5708), (0.4, -0.6), (-2.6, 1.2)]
"""Of wrist 1 and 2 [rad]: the tool down, and askew."""


def g(robot: tool0.Robot) -> float:
    """Return how fast things fall [m/s²]: Gazebo's 9.8, or MuJoCo's 9.81."""
    return -robot.engine.world.gravity[2]


def tool_links(model: RobotModel) -> list[str]:
    def below(link: str) -> list[str]:
        children = [joint.child for joint in model.child_joints[link]]
        return [link, *itertools.chain.from_iterable(map(below, children))]

    return below("tool0")


def mass_and_center(
    model: RobotModel, position: dict[str, float]
) -> tuple[float, np.ndarray]:
    """Return mass [kg] and centre of mass [m] of all beyond the flange, in the root."""
    frames = link_poses(model, position)
    mass, moment = 0.0, np.zeros(3)
    for name in tool_links(model):
        inertial = model.link(name).inertial
        if inertial is not None:
            center = frames[name] @ to_transform(inertial.origin)
            mass += inertial.mass
            moment += inertial.mass * np.array(center.position)
    return mass, moment / mass


def in_root(robot: tool0.Robot, vector: tuple[float, float, float]) -> np.ndarray:
    """Return a vector of tool0's axes in the root's."""
    turned: np.ndarray = np.array(robot.pose("tool0").rotation) @ vector
    return turned


def test_what_hangs_on_the_flange_pulls_with_its_weight_and_lever(
    bring_up: BringUp,
) -> None:
    robot = bring_up()
    for wrists in WRISTS:
        robot.reset(dict(zip(("wrist_1_joint", "wrist_2_joint"), wrists, strict=True)))
        robot.run(1.0)
        reading = robot.force_torque.read()
        assert reading.frame == "tool0"
        assert reading.time == pytest.approx(1.0)
        model = robot.description.model
        mass, center = mass_and_center(model, dict(robot.joint_state.position))
        weight = mass * np.array(robot.engine.world.gravity)
        moment = np.cross(center - robot.pose("tool0").position, weight)
        for force, torque in (
            (reading.force, reading.torque),
            (reading.raw_force, reading.raw_torque),
        ):
            pull, turn = in_root(robot, force), in_root(robot, torque)
            np.testing.assert_allclose(pull, weight, atol=0.01 * mass * g(robot))
            np.testing.assert_allclose(turn, moment, atol=0.001 * mass * g(robot))


def test_a_tool_that_hangs_down_pulls_along_its_z_until_zeroed(
    bring_up: BringUp,
) -> None:
    robot = bring_up()
    robot.run(1.0)
    assert robot.force_torque.read().force[2] == pytest.approx(
        0.921 * g(robot), rel=5e-4
    )
    robot.force_torque.zero()
    assert robot.force_torque.read().force == (0.0, 0.0, 0.0)
    robot.run(0.5)
    reading = robot.force_torque.read()
    np.testing.assert_allclose((*reading.force, *reading.raw_force), 0.0, atol=0.01)
    np.testing.assert_allclose((*reading.torque, *reading.raw_torque), 0.0, atol=1e-3)
    robot.reset()
    robot.run(0.5)  # a sensor keeps its zero
    assert robot.force_torque.read().force[2] == pytest.approx(0.0, abs=0.05)
    robot.force_torque.start()
    assert robot.force_torque.read().force[2] == pytest.approx(
        0.921 * g(robot), rel=0.01
    )


def test_what_is_held_weighs(bring_up: BringUp) -> None:
    cube = SceneObject(
        name="cube",
        geometry=Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=BETWEEN_PADS),
        mass=0.5,
    )
    robot = bring_up(scene=Scene((TABLE, cube)), initial_pose="ready")
    robot.force_torque.start()
    robot.gripper.move(opening=0.0, force=100.0)
    robot.run(1.0)
    robot.controller(ARM).follow([point(HOME, 2.0)]).wait(10.0)
    robot.run(1.0)
    mass, _ = mass_and_center(robot.description.model, dict(robot.joint_state.position))
    pull = in_root(robot, robot.force_torque.read().force)[2] + mass * g(robot)
    assert pull == pytest.approx(-0.5 * g(robot), rel=0.03)


def test_what_is_pressed_on_presses_back(bring_up: BringUp) -> None:
    robot = bring_up(
        scene=Scene((TABLE,)), initial_pose={**ABOVE_TABLE, "finger_joint": 0.8}
    )
    robot.force_torque.zero()
    down = {"shoulder_lift_joint": -1.18}
    robot.controller(ARM).move(down, speed=0.1, collision="ignore").wait(10.0)
    robot.run(1.0)
    pressing = np.zeros(3)
    links = tool_links(robot.description.model)
    for contact in robot.contacts():
        if contact.first in links and contact.second == "table":
            pressing += contact.force
        elif contact.second in links and contact.first == "table":
            pressing -= contact.force
    assert pressing[2] < -10.0
    felt = in_root(robot, robot.force_torque.read().force)
    np.testing.assert_allclose(
        felt, -pressing, atol=0.03 * float(np.linalg.norm(pressing))
    )


def test_what_is_felt_on_the_way_is_what_changes_the_momentum(
    bring_up: BringUp,
) -> None:
    robot = bring_up()
    model = robot.description.model
    robot.force_torque.start(rate=1000.0)
    arm = {"shoulder_pan_joint": 1.0, "elbow_joint": 1.0, "wrist_3_joint": 2.0}
    robot.controller(ARM).move(arm, speed=1.0)
    robot.gripper.move(opening=0.0)
    mass, before = mass_and_center(model, dict(robot.joint_state.position))
    impulse, last = np.zeros(3), robot.force_torque.read()
    n_fast = 0
    for k in range(1, 601):
        robot.run(0.001)
        (reading,) = robot.force_torque.samples(since=last.number)
        impulse -= 0.001 * in_root(robot, reading.raw_force)
        impulse += 0.001 * mass * np.array(robot.engine.world.gravity)
        last = reading
        if k % 100 == 99:
            _, before = mass_and_center(model, dict(robot.joint_state.position))
        elif k % 100 == 0:
            _, after = mass_and_center(model, dict(robot.joint_state.position))
            momentum = mass * (after - before) / 0.001
            np.testing.assert_allclose(impulse, momentum, atol=0.005)
            n_fast += bool(np.linalg.norm(momentum) > 0.25)
    assert n_fast >= 3
