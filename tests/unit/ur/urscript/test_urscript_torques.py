"""Torque control by URScript, on the control box of a simulated robot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from served import serving, use_folder
from urscript_rig import BoxRig, box_rig

import tool0
from tool0.description.bodies import JointDynamics
from tool0.description.model import RobotModel
from tool0.description.velocity_torques import velocity_efforts

pytestmark = pytest.mark.slow

HALF = 0.5
"""Simulated seconds per wall second: programs keep up also on a busy machine."""
READY = (0.0, -1.2, 1.9, -2.2708, -1.5708, 0.0)  # [rad]
Q = (0.3, -1.1, 1.3, -0.4, 0.9, 0.2)  # [rad]
QD = (0.5, -0.4, 0.8, 1.1, -0.9, 0.7)  # [rad/s]
TCP = (0.02, -0.03, 0.15, 0.0, 0.0, 0.0)  # [m, rad]
STEP = 1e-6
"""Of derivatives [rad, s]."""


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(
        arm="ur5e", gripper=None, initial_pose="ready", speed=HALF
    ) as robot:
        yield robot


@pytest.fixture(scope="module")
def rig(
    robot: tool0.Robot, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[BoxRig]:
    with pytest.MonkeyPatch.context() as patch:
        use_folder(patch, tmp_path_factory.mktemp("run"))
        with serving(robot), box_rig() as rig:
            yield rig


@pytest.fixture(autouse=True)
def at_ready(robot: tool0.Robot) -> None:
    """Start each test as just brought up."""
    box = robot.arm.control_box
    box.restart_safety()
    box.release_brakes()
    box.clear_payload()
    robot.reset()


@pytest.fixture
def model(robot: tool0.Robot) -> RobotModel:
    return robot.description.model


# ---- dynamics ------------------------------------------------------------------------


def test_masses_and_velocity_torques_are_those_of_the_model(
    rig: BoxRig, model: RobotModel
) -> None:
    dynamics, box = JointDynamics(model), rig.box.dynamics
    masses = dynamics.mass_matrix(Q)
    np.testing.assert_allclose(box.mass_matrix(Q), masses, atol=1e-9)
    with_rotors = masses + 0.1 * np.eye(6)
    found = box.mass_matrix(Q, with_rotors=True)
    np.testing.assert_allclose(found, with_rotors, atol=1e-9)
    expected = velocity_efforts(dynamics, Q, QD)
    np.testing.assert_allclose(box.velocity_torques(Q, QD), expected, atol=1e-9)


def test_the_payload_counts(rig: BoxRig, robot: tool0.Robot) -> None:
    before = np.array(rig.box.dynamics.mass_matrix(Q))
    place = (0.0, 0.0, 0.1)
    robot.arm.control_box.set_payload(3.0, place)
    rig.do(rig.box.until(lambda: rig.box.state.payload.mass == 3.0))
    after = np.array(rig.box.dynamics.mass_matrix(Q))
    J = np.array(rig.box.dynamics.jacobian(Q, (*place, 0.0, 0.0, 0.0)))
    inertia = rig.box.state.payload.inertia
    added = 3.0 * J[:3].T @ J[:3] + inertia * J[3:].T @ J[3:]
    np.testing.assert_allclose(after - before, added, atol=1e-9)


def test_the_jacobian_is_the_derivative_of_the_pose(rig: BoxRig) -> None:
    def place(q: np.ndarray) -> np.ndarray:
        return np.array(rig.box.forward(q.tolist(), TCP)[:3])

    q, J = np.array(Q), np.array(rig.box.dynamics.jacobian(Q, TCP))
    for k, unit in enumerate(STEP * np.eye(6)):
        slope = (place(q + unit) - place(q - unit)) / (2.0 * STEP)
        np.testing.assert_allclose(J[:3, k], slope, atol=1e-8)
    axes = rig.box.posture_at(Q).axes
    np.testing.assert_allclose(J[3:], np.transpose(axes), atol=1e-12)


def test_its_time_derivative_is_that_of_the_jacobian(rig: BoxRig) -> None:
    def jacobian(time: float) -> np.ndarray:
        q = np.add(Q, time * np.array(QD)).tolist()
        return np.array(rig.box.dynamics.jacobian(q, TCP))

    slope = (jacobian(STEP) - jacobian(-STEP)) / (2.0 * STEP)
    found = rig.box.dynamics.jacobian_derivative(Q, QD, TCP)
    np.testing.assert_allclose(found, slope, atol=1e-8)


def test_programs_get_matrices_as_rows(rig: BoxRig) -> None:
    run = rig.run(f"""
def ask():
  m = get_mass_matrix({list(Q)})
  textmsg(get_mass_matrix({list(Q)}, True)[0, 0] - m[0, 0])
  textmsg(get_jacobian({list(Q)}, p{list(TCP)})[5, 0])
  textmsg(size(get_jacobian_time_derivative()))
  textmsg(length(get_coriolis_and_centrifugal_torques({list(Q)}, {list(QD)})))
  textmsg((m * {list(QD)})[0] > 0)
  textmsg(norm(get_actual_joint_accelerations()) < 1)
end
""")
    assert not run.errors
    assert run.texts == ["0.1", "1", "[6, 6]", "6", "True", "True"]


# ---- torques -------------------------------------------------------------------------


def test_without_torque_the_arm_floats(rig: BoxRig) -> None:
    run = rig.run("""
def floating():
  sleep(0.5)
  q = get_actual_joint_positions()
  i = 0
  while i < 250:
    direct_torque([0, 0, 0, 0, 0, 0])
    i = i + 1
  end
  textmsg(norm(get_actual_joint_positions() - q) < 0.001)
end
""")
    assert not run.errors
    assert run.texts == ["True"]
    assert run.duration == pytest.approx(1.0, abs=0.1)


def test_a_program_controls_impedances(rig: BoxRig) -> None:
    """A joint spring moves the arm, and a move continues from where it is."""
    run = rig.run("""
def impedance():
  sleep(0.5)
  start = get_actual_joint_positions()
  goal = start + [0.2, 0, 0, 0, 0, 0]
  stiffness = [600, 600, 400, 100, 100, 100]
  damping = [60, 60, 40, 5, 5, 5]
  i = 0
  while i < 1000:
    q = get_actual_joint_positions()
    qd = get_actual_joint_speeds()
    spring = stiffness * (goal - q) - damping * qd
    direct_torque(spring + get_coriolis_and_centrifugal_torques(q, qd))
    i = i + 1
  end
  textmsg(norm(goal - get_actual_joint_positions()) < 0.01)
  movej(start)
  textmsg(norm(start - get_actual_joint_positions()) < 0.01)
end
""")
    assert not run.errors
    assert run.texts == ["True", "True"]


def test_without_a_call_the_arm_returns_to_position_control(
    rig: BoxRig, robot: tool0.Robot
) -> None:
    run = rig.run("""
def push():
  i = 0
  while i < 50:
    direct_torque([20, 0, 0, 0, 0, 0])
    i = i + 1
  end
  textmsg(get_actual_joint_speeds()[0] > 0.2)
  sleep(1)
  q = get_actual_joint_positions()
  sleep(0.5)
  textmsg(norm(get_actual_joint_positions() - q) < 0.001)
end
""")
    assert not run.errors
    assert run.texts == ["True", "True"]
    assert not robot.arm.control_box.state.protective_stop


@pytest.mark.parametrize(
    ("torque", "reason"),
    [
        ([0, 0, 0, 0, 28, 0], "largest speed"),
        ([0, 0, 0, 0, 0, 30], "beyond its limit of 28"),
    ],
)
def test_a_violation_is_a_protective_stop(
    rig: BoxRig, robot: tool0.Robot, torque: list[int], reason: str
) -> None:
    run = rig.run(f"""
def push():
  direct_torque([0, 0, 0, 0, 0, 0])
  while True:
    direct_torque({torque})
  end
end
""")
    assert reason in robot.arm.control_box.state.protective_stop
    assert any("protective stop" in text for text in run.errors)


def test_wrong_arguments_are_named(rig: BoxRig) -> None:
    for call, reason in (
        ("direct_torque([0, 0, 0])", "six"),
        ("direct_torque([0, 0, 0, 0, 0, 0], [2, 1, 1, 1, 1, 1])", "viscous_scale"),
        ("direct_torque([0, 0, 0, 0, 0, 0], friction_comp=1)", "boolean"),
        ("torque_command([0, 0, 0, 0, 0, 0])", "direct_torque"),
        ("optimovej([0, 0, 0, 0, 0, 0], a=2)", "at most 1"),
    ):
        try:
            errors = rig.run(f"def wrong():\n  {call}\nend\n").errors
        except tool0.Tool0Error as error:
            errors = [str(error)]
        assert errors, call
        assert reason in errors[0], errors


def test_optimoves_are_moves_at_a_part_of_the_speed(rig: BoxRig) -> None:
    run = rig.run(f"""
def fast():
  motion_version_set(2)
  textmsg(motion_version_get())
  optimovej({list(READY)}, a=1, v=1)
  start = get_actual_tcp_pose()
  optimovej(get_actual_joint_positions() + [0.4, 0, 0, 0, 0, 0], a=0.5, v=0.5, r=0)
  optimovel(start, a=0.5, v=0.5)
  textmsg(point_dist(start, get_actual_tcp_pose()) < 0.002)
end
""")
    assert not run.errors
    assert run.texts == ["2", "True"]
