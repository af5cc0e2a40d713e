"""Torques of a program: what they do, and what ends them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from conformance_types import BringUp
from numpy.typing import NDArray
from raises_naming import raises_naming
from ur5_rig import ARM_JOINTS

import tool0
from tool0.control.arm.torque import VISCOUS_FRICTION, WARM
from tool0.description.bodies import ROTOR_INERTIA, JointDynamics
from tool0.description.velocity_torques import velocity_efforts

Array = NDArray[np.float64]
POSE = (0.3, -1.2, 1.4, -0.9, -1.3, 0.4)
FULL = (1.0,) * 6
LIMITS = np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0])  # [N·m]
FASTEST = np.pi  # [rad/s]
END = 2.0 * np.pi  # [rad]
PERIOD = 0.002  # [s]

Law = Callable[[Array, Array], Array]


class Torques:
    """A robot whose arm was taken."""

    def __init__(self, robot: tool0.Robot) -> None:
        self.robot, self.motion = robot, robot.arm.motion
        self.motion.take()
        robot.run(0.3)
        self.passed: list[Array] = []
        """Positions and velocities after each millisecond."""

    @property
    def q(self) -> Array:
        return np.array(self.robot.snapshot.position)

    @property
    def qd(self) -> Array:
        return np.array(self.robot.snapshot.velocity)

    def drive(self, law: Law, duration: float) -> None:
        """Drive with a law, every 2 ms, until it is refused."""
        for _ in range(round(duration / PERIOD)):
            torques = law(self.q, self.qd)
            self.motion.drive_torques(
                np.clip(torques, -LIMITS, LIMITS),
                viscous_scale=FULL,
                coulomb_scale=FULL,
            )
            self.run(PERIOD)

    def run(self, duration: float) -> None:
        for _ in range(round(duration / 0.001)):
            self.robot.run(0.001)
            self.passed.append(np.stack([self.q, self.qd]))

    def fastest(self) -> float:
        return float(max(abs(state[1]).max() for state in self.passed))

    def furthest(self) -> float:
        return float(max(abs(state[0]).max() for state in self.passed))


def constant(torques: Sequence[float]) -> Law:
    return lambda q, qd: np.array(torques)


@pytest.fixture
def torques(bring_up: BringUp, engine: str) -> Torques:
    if engine == "gazebo":
        pytest.skip("Gazebo has no torque control")
    pose = dict(zip(ARM_JOINTS, POSE, strict=True))
    return Torques(bring_up(arm="ur5e", gripper=None, initial_pose=pose))


def test_an_engine_without_rotors_refuses(bring_up: BringUp, engine: str) -> None:
    robot = bring_up(arm="ur5e", gripper=None)
    motion = robot.arm.motion
    motion.take()
    if engine == "gazebo":
        with raises_naming(tool0.ControlError, "gazebo", "rotors", "MuJoCo"):
            motion.drive_torques([0.0] * 6)
        assert motion.state.mode == "hold"
    else:
        motion.drive_torques([0.0] * 6)
        assert motion.state.mode == "torque"


def test_without_torque_the_arm_floats(torques: Torques) -> None:
    before = torques.q
    torques.drive(constant([0.0] * 6), 1.0)
    assert torques.motion.state.mode == "torque"
    np.testing.assert_allclose(torques.q, before, atol=1e-4)


@pytest.mark.parametrize("joint", range(6))
def test_a_torque_accelerates_as_the_masses_predict(
    torques: Torques, joint: int
) -> None:
    """With all dry friction and the known part of the viscous one compensated."""
    torque = np.zeros(6)
    torque[joint] = LIMITS[joint] * 0.1
    torques.drive(constant(torque), 0.04)
    start, first = torques.q, torques.qd
    torques.drive(constant(torque), 0.01)
    rate = (torques.qd - first) / 0.01
    q, qd = 0.5 * (start + torques.q), 0.5 * (first + torques.qd)
    dynamics = JointDynamics(torques.robot.description.model)
    masses = dynamics.mass_matrix(q.tolist()) + ROTOR_INERTIA * np.eye(6)
    needed = masses @ rate + velocity_efforts(dynamics, q.tolist(), qd.tolist())
    left = torque - (1.0 - WARM) * VISCOUS_FRICTION * LIMITS * qd
    assert abs(rate[joint]) > 1.0
    np.testing.assert_allclose(needed, left, atol=0.03 * torque[joint])


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_that_is_too_fast_is_a_protective_stop(
    torques: Torques, joint: int, sign: float
) -> None:
    torque = np.zeros(6)
    torque[joint] = sign * LIMITS[joint]
    with raises_naming(tool0.ControlError, "protective stop", "rad/s"):
        torques.drive(constant(torque), 2.0)
    torques.run(0.5)
    reason = torques.robot.arm.control_box.state.protective_stop
    assert "largest speed" in reason
    assert torques.fastest() < 1.01 * FASTEST
    assert abs(torques.qd).max() < 1e-3
    assert torques.robot.arm.control_box.state.safety_mode.name == "PROTECTIVE_STOP"


@pytest.mark.parametrize("joint", [0, 3, 4, 5])
@pytest.mark.parametrize("speed", [0.3, 2.5])
def test_a_joint_stops_before_the_end_of_its_range(
    torques: Torques, joint: int, speed: float
) -> None:
    """Whatever its speed; the others hold their places."""
    torques.robot.reset({ARM_JOINTS[joint]: END - 0.6})
    goal = torques.q
    stiffness, damping = 3.0 * LIMITS, 0.3 * LIMITS

    def law(q: Array, qd: Array) -> Array:
        found = stiffness * (goal - q) - damping * qd
        found[joint] = 3.0 * damping[joint] * (speed - qd[joint])
        return np.asarray(found)

    with raises_naming(tool0.ControlError, ARM_JOINTS[joint], "limits"):
        torques.drive(law, 5.0)
    torques.run(0.5)
    assert torques.furthest() < END + 0.001
    assert torques.furthest() > END - 0.3
    assert "stop within its limits" in (
        torques.robot.arm.control_box.state.protective_stop
    )


def test_without_further_torques_the_arm_stops_and_holds(torques: Torques) -> None:
    torques.drive(constant([20.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 0.1)
    assert torques.qd[0] > 0.3
    torques.robot.run(0.1)
    assert torques.motion.state.mode == "stop"
    torques.motion.wait(2.0)
    torques.robot.run(0.5)
    rest = torques.q
    torques.robot.run(0.5)
    np.testing.assert_allclose(torques.q, rest, atol=1e-4)
    assert not torques.robot.arm.control_box.state.protective_stop


def test_torques_end_when_told_and_by_other_motions(torques: Torques) -> None:
    motion = torques.motion
    motion.drive_torques([0.0] * 6)
    motion.end_torques()
    assert motion.state.mode == "stop"
    motion.drive_torques([0.0] * 6)
    motion.servo_joints(torques.q)
    assert motion.state.mode == "servo"
    motion.stop()
    torques.robot.run(0.5)
    motion.drive_torques([0.0] * 6)
    motion.release()
    torques.robot.run(0.5)
    assert motion.state.mode == "free"


def test_more_torque_than_a_drive_has_is_refused(torques: Torques) -> None:
    torques.motion.drive_torques([0.0] * 6)
    with raises_naming(tool0.ControlError, "elbow_joint", "150", "160"):
        torques.motion.drive_torques([0.0, 0.0, 160.0, 0.0, 0.0, 0.0])
    with raises_naming(tool0.ControlError, "freedrive"):
        torques.motion.start_freedrive()
        torques.motion.drive_torques([0.0] * 6)
    torques.motion.end_freedrive()
    torques.robot.run(0.5)
    assert torques.motion.state.is_done


def test_two_runs_are_identical(bring_up: BringUp, engine: str) -> None:
    if engine == "gazebo":
        pytest.skip("Gazebo has no torque control")
    ends = []
    for _ in range(2):
        arm = Torques(bring_up(arm="ur5e", gripper=None))
        arm.drive(constant([15.0, 5.0, -5.0, 1.0, 2.5, 2.5]), 0.1)
        ends.append(arm.q)
    np.testing.assert_array_equal(*ends)
