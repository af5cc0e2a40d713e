"""Streams of an arm: the law of servo, ramps of velocities, limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from toy_robot import make_joint

from tool0.control.arm.model import ArmDynamics, Placement
from tool0.control.arm.stream import (
    MAX_ACCELERATION,
    SINGULAR,
    ServoStream,
    SpeedStream,
    damped_inverse,
)
from tool0.control.arm.stream import _fastest_before as fastest_before
from tool0.hardware.engine import JointState
from tool0.protocol.state import ArmSetpoint

DT = 0.001
JOINTS = [make_joint(f"joint{k}") for k in range(6)]
REST = ArmSetpoint.resting((0.0,) * 6)


class Linear:
    """Six joints that move a point along and about three axes."""

    def __init__(self, J: np.ndarray | None = None) -> None:
        self.J = np.eye(6) if J is None else J

    def place(self, q: np.ndarray, lever: np.ndarray) -> Placement:
        return Placement(q[:3], np.eye(3), self.J)

    def dynamics(self, state: JointState) -> ArmDynamics:
        raise NotImplementedError


def speed(start: ArmSetpoint = REST, J: np.ndarray | None = None) -> SpeedStream:
    return SpeedStream(start, JOINTS, Linear(J))


def six(*values: float) -> tuple[float, ...]:
    return (*values, *[0.0] * (6 - len(values)))


def test_servo_follows_its_law() -> None:
    """Against the recurrence with constant accelerations, and its solution."""
    servo = ServoStream(REST, JOINTS)
    servo.aim(six(0.1, -0.05), lookahead_time=0.1, gain=300.0)
    q = v = 0.0
    for k in range(2000):
        servo.advance(k * DT, DT, 1.0)
        a = 300.0 * (0.1 - (q + 0.1 * v))
        q, v = q + v * DT + 0.5 * a * DT * DT, v + a * DT
        assert servo.setpoint.positions[0] == pytest.approx(q, abs=1e-9)
        assert servo.setpoint.velocities[0] == pytest.approx(v, abs=1e-9)
        assert servo.setpoint.accelerations[0] == pytest.approx(a, abs=1e-9)
        assert servo.setpoint.positions[1] == pytest.approx(-0.5 * q, abs=1e-9)
        if k == 99:  # at 0.1 s: the damped oscillator q" = 300 (0.1 - q - 0.1 q')
            w, d = math.sqrt(300.0 - 15.0**2), 15.0
            t = 0.1
            exact = 0.1 * (
                1.0 - math.exp(-d * t) * (math.cos(w * t) + d / w * math.sin(w * t))
            )
            assert q == pytest.approx(exact, rel=0.01)
    assert servo.setpoint.positions == pytest.approx(six(0.1, -0.05), abs=1e-6)


@pytest.mark.slow
def test_servo_keeps_to_the_limits_of_the_joints() -> None:
    servo = ServoStream(REST, JOINTS)
    servo.aim(six(6.0, 3.0), lookahead_time=0.03, gain=2000.0)
    before = REST
    for k in range(6000):
        servo.advance(k * DT, DT, 0.5 if k < 100 else 1.0)
        now = servo.setpoint
        assert max(map(abs, now.velocities)) <= (1.5 if k < 100 else 3.0) + 1e-9
        assert max(map(abs, now.accelerations)) <= MAX_ACCELERATION + 1e-6
        assert now.positions[0] <= 6.0
        for q, v, a, old in zip(*now, before.positions, strict=True):
            assert q - old == pytest.approx(v * DT - 0.5 * a * DT * DT, abs=1e-12)
        before = now
    assert now.positions[0] == pytest.approx(6.0, abs=1e-3)


def test_servo_stands_still_while_the_program_is_paused() -> None:
    servo = ServoStream(REST._replace(velocities=six(1.0)), JOINTS)
    servo.aim(six(2.0), lookahead_time=0.1, gain=300.0)
    for k in range(100):
        servo.advance(k * DT, DT, 0.0)
    assert servo.setpoint.is_at_rest


@pytest.mark.parametrize("rate", [125.0, 500.0, 1000.0])
def test_velocities_ramp_with_the_leading_joint(rate: float) -> None:
    stream, dt = speed(), 1.0 / rate
    stream.aim(six(1.0, -0.5), 2.0, until=1.0)
    n = round(0.24 * rate)
    for k in range(n):
        stream.advance(k * dt, dt, 1.0)
    t = n * dt
    assert stream.setpoint.velocities == pytest.approx(six(2 * t, -t), abs=1e-9)
    assert stream.setpoint.positions == pytest.approx(
        six(t * t, -0.5 * t * t), abs=1e-9
    )
    assert stream.setpoint.accelerations == pytest.approx(six(2, -1), abs=1e-9)
    for k in range(n, round(rate)):
        stream.advance(k * dt, dt, 1.0)
    assert stream.setpoint.velocities == pytest.approx(six(1.0, -0.5), abs=1e-9)
    for k in range(round(rate), 2 * round(rate)):
        stream.advance(k * dt, dt, 1.0)
    assert stream.setpoint.is_at_rest  # 1 s has passed
    assert stream.setpoint.positions[0] == pytest.approx(1.0, abs=1e-9)


def test_the_speed_slider_slows_down_the_clock_of_velocities() -> None:
    stream = speed()
    stream.aim(six(1.0), 10.0)
    for k in range(200):  # as 0.1 s at full speed
        stream.advance(k * DT, DT, 0.5)
    assert stream.setpoint.velocities[0] == pytest.approx(0.5)
    ramp = 0.5 * 1.0 * 0.1
    assert stream.setpoint.positions[0] == pytest.approx(ramp)
    for k in range(200, 400):
        stream.advance(k * DT, DT, 0.5)
    assert stream.setpoint.positions[0] == pytest.approx(ramp + 0.1)


@pytest.mark.parametrize("acceleration", [0.01, 10.0])
def test_a_pause_stops_velocities_and_their_end_is_not_slowed_down(
    acceleration: float,
) -> None:
    stream = speed(ArmSetpoint.resting(six())._replace(velocities=six(0.4)))
    stream.aim(six(0.4), acceleration, until=10.0)
    stream.advance(0.0, DT, 1.0)
    for k in range(100):
        stream.advance(k * DT, DT, 0.0)
    assert stream.setpoint.is_at_rest
    stream.aim(six(0.4), 10.0, until=10.0)
    for k in range(400):
        stream.advance(1.0 + k * DT, DT, 0.5)
    assert stream.setpoint.velocities[0] == pytest.approx(0.2)
    for k in range(20):
        stream.advance(10.0 + k * DT, DT, 0.5)
    assert stream.setpoint.is_at_rest


def test_velocities_end_before_a_position_limit() -> None:
    stream = speed(ArmSetpoint.resting(six(5.0, 0.0)))
    stream.aim(six(3.0, 3.0), 20.0)
    for k in range(3000):
        stream.advance(k * DT, DT, 1.0)
        assert stream.setpoint.positions[0] <= 6.0
        v, w, *_ = stream.setpoint.velocities
        assert v == pytest.approx(w)  # the direction stays
    assert stream.setpoint.positions[0] == pytest.approx(6.0, abs=1e-3)
    assert fastest_before(-0.1, 7.5, DT) == 0.0
    v = fastest_before(0.5, 7.5, DT)
    assert (v + 7.5 * DT / 2) ** 2 / 15.0 == pytest.approx(0.5)
    assert fastest_before(math.inf, 7.5, DT) == math.inf


def test_a_twist_of_the_tool_ramps_along_a_line() -> None:
    J = np.eye(6)
    J[0, 3] = 0.5
    stream = speed(J=J)
    stream.aim((0.3, 0.4, 0.0, 0.1, 0.0, 0.0), 1.0, lever=np.zeros(3))
    for k in range(100):
        stream.advance(k * DT, DT, 1.0)
    twist = J @ stream.setpoint.velocities
    assert twist == pytest.approx([0.06, 0.08, 0, 0.02, 0, 0], abs=1e-9)
    for k in range(100, 700):
        stream.advance(k * DT, DT, 1.0)
    twist = J @ stream.setpoint.velocities
    assert twist == pytest.approx([0.3, 0.4, 0, 0.1, 0, 0], abs=1e-9)


def test_a_singular_arm_slows_down_instead_of_racing() -> None:
    J = np.diag([1.0, 1.0, 1e-4, 1.0, 1.0, 1.0])
    twist = np.array([0.1, 0, 0.1, 0, 0, 0])
    found = damped_inverse(J, twist)
    assert found[0] == pytest.approx(0.1, rel=1e-3)
    assert abs(found[2]) < 0.1 / SINGULAR / 2
    regular = np.diag([1.0, 1.0, 0.5, 1.0, 1.0, 1.0])
    assert damped_inverse(regular, twist) == pytest.approx([0.1, 0, 0.2, 0, 0, 0])
    stream = speed(J=J)
    stream.aim((0.0, 0.0, 1.0, 0.0, 0.0, 0.0), 1000.0, lever=np.zeros(3))
    for k in range(1000):
        stream.advance(k * DT, DT, 1.0)
        assert max(map(abs, stream.setpoint.velocities)) <= 3.0 + 1e-9
