"""Paths of an arm: their knots, replacement, scaling, and ramps to rest."""

from __future__ import annotations

import math
from typing import Any

import pytest
from toy_robot import make_joint

from tool0.control.arm.path import ArmPath, SplineMotion
from tool0.errors import ControlError
from tool0.protocol.state import ArmSetpoint

DT = 0.001
JOINTS = [make_joint("hip"), make_joint("knee")]
EXACT = 1e-9


def path(
    times: Any, positions: Any, velocities: Any, accelerations: Any = ()
) -> ArmPath:
    return ArmPath.of(JOINTS, times, positions, velocities, accelerations)


def started(start: Any = (0.0, 0.0), now: float = 0.0, **knots: Any) -> SplineMotion:
    """Follow a path from rest."""
    setpoint = ArmSetpoint.resting(start)
    return SplineMotion.along(path(**knots), 1, setpoint, now, 1.0)


def commands(
    motion: SplineMotion, start: float, count: int, factor: float = 1.0
) -> list[Any]:
    return [motion.update(start + k * DT, DT, factor) for k in range(count)]


def test_a_path_is_cubic_between_knots_without_accelerations() -> None:
    motion = started(times=[2.0], positions=[[1.0, -2.0]], velocities=[[0, 0]])
    for time in (0.0, 0.3, 1.0, 1.7, 2.0):
        q, qd, qdd = motion.setpoint(time)
        s = time / 2.0
        assert q == pytest.approx([3 * s**2 - 2 * s**3, -6 * s**2 + 4 * s**3], abs=1e-9)
        assert qd[0] == pytest.approx(3 * s * (1 - s), abs=EXACT)
        assert qdd[0] == pytest.approx(1.5 * (1 - 2 * s), abs=EXACT)
    assert not motion.is_done(1.9)
    assert motion.is_done(2.0)
    assert motion.progress(1.25) == (1, 1.25)


def test_phases_of_constant_acceleration_are_exact() -> None:
    """Accelerate with 2 rad/s² for 0.5 s, cruise for 1 s, brake."""
    motion = started(
        times=[0.5, 1.5, 2.0],
        positions=[[0.25, 0], [1.25, 0], [1.5, 0]],
        velocities=[[1, 0], [1, 0], [0, 0]],
    )
    assert motion.setpoint(0.3)[0][0] == pytest.approx(0.09, abs=EXACT)
    assert motion.setpoint(0.3)[2][0] == pytest.approx(2.0, abs=EXACT)
    assert motion.setpoint(1.0)[1][0] == pytest.approx(1.0, abs=EXACT)
    assert motion.setpoint(1.75)[2][0] == pytest.approx(-2.0, abs=EXACT)


def test_a_path_is_quintic_with_accelerations() -> None:
    rows = [[0.0, 0.0]]
    motion = started(
        times=[1.0], positions=[[1.0, 1.0]], velocities=rows, accelerations=rows
    )
    s = 0.37
    q, qd, qdd = motion.setpoint(s)
    assert q[0] == pytest.approx(10 * s**3 - 15 * s**4 + 6 * s**5, abs=EXACT)
    assert qd[0] == pytest.approx(30 * s**2 * (1 - s) ** 2, abs=EXACT)
    assert qdd[0] == pytest.approx(60 * s - 180 * s**2 + 120 * s**3, abs=EXACT)


def test_the_command_of_a_tick_is_the_setpoint_at_its_end() -> None:
    motion = started(times=[1.0], positions=[[1.0, 1.0]], velocities=[[0, 0]])
    for k, command in enumerate(commands(motion, 0.0, 900)):
        wanted = motion.setpoint((k + 1) * DT)[0]
        assert command == pytest.approx(wanted, abs=1e-12)


def test_a_path_may_start_with_the_setpoint_itself() -> None:
    motion = started(
        times=[0.0, 1.0],
        positions=[[5e-7, 0], [1, 1]],
        velocities=[[0, 0], [0, 0]],
    )
    assert motion.setpoint(0.0)[0] == (5e-7, 0.0)
    with pytest.raises(ControlError, match="must begin with the setpoint: joint 1"):
        started(
            times=[0.0, 1.0],
            positions=[[0, 2e-6], [1, 1]],
            velocities=[[0, 0], [0, 0]],
        )


def test_replacement_leaves_the_old_path_at_the_given_time() -> None:
    motion = started(times=[2.0], positions=[[2.0, 0.0]], velocities=[[0, 0]])
    old = [motion.setpoint(k / 100) for k in range(101)]
    new = path([1.0], [[0.0, 1.0]], [[0, 0]])
    motion.replaced(new, 2, after=1, at=1.0, now=0.4)
    assert [motion.setpoint(k / 100) for k in range(40, 100)] == old[40:100]
    assert motion.progress(0.9) == (1, 0.9)
    assert motion.progress(1.3)[0] == 2
    assert motion.progress(1.3)[1] == pytest.approx(0.3)
    before, after = motion.setpoint(1.0), motion.setpoint(math.nextafter(1.0, 2.0))
    for one, other in zip(before[:2], after[:2], strict=True):
        assert one == pytest.approx(other, abs=EXACT)
    assert not motion.is_done(1.9)
    assert motion.is_done(2.0)
    assert motion.setpoint(2.5)[0] == pytest.approx([0.0, 1.0])


def test_replacements_can_be_queued_and_replaced() -> None:
    motion = started(times=[2.0], positions=[[2.0, 0.0]], velocities=[[0, 0]])
    again = path([1.0], [[0.0, 1.0]], [[0, 0]])
    motion.replaced(again, 2, after=1, at=1.0, now=0.1)
    motion.replaced(again, 3, after=2, at=0.5, now=0.2)
    assert motion.progress(1.6)[0] == 3
    with pytest.raises(ControlError, match=r"path 2 replaces path 1 from 1\.0+ s on"):
        motion.replaced(again, 4, after=1, at=1.2, now=0.3)
    motion.replaced(again, 4, after=1, at=0.8, now=0.3)
    assert motion.progress(0.9)[0] == 4
    with pytest.raises(ControlError, match=r"path 2 is not executed.*1, 4"):
        motion.replaced(again, 5, after=2, at=0.1, now=0.3)
    with pytest.raises(ControlError, match=r"path 1 is at 0\.5.* s already"):
        motion.replaced(again, 5, after=1, at=0.4, now=0.5)


def test_the_speed_scales_the_time_of_a_path() -> None:
    motion = started(times=[2.0], positions=[[2.0, 0.0]], velocities=[[0, 0]])
    full = started(times=[2.0], positions=[[2.0, 0.0]], velocities=[[0, 0]])
    before = commands(motion, 0.0, 500)[-1]
    slow = commands(motion, 0.5, 500, 0.25)
    assert before == pytest.approx(full.setpoint(0.5)[0], abs=1e-12)
    for k in (0, 100, 499):
        time = 0.5 + 0.25 * (k + 1) * DT
        assert slow[k] == pytest.approx(full.setpoint(time)[0], abs=EXACT)
    now = motion.setpoint(1.0)
    wanted = full.setpoint(0.625)
    assert motion.progress(1.0) == (1, pytest.approx(0.625))
    assert now[1][0] == pytest.approx(0.25 * wanted[1][0])
    assert now[2][0] == pytest.approx(0.0625 * wanted[2][0])
    paused = commands(motion, 1.0, 10, 0.0)
    assert paused == [paused[0]] * 10


def test_a_ramp_to_rest_has_the_deceleration_of_the_leading_joint() -> None:
    start = ArmSetpoint((0.0, 1.0), (1.0, -0.5), (3.0, 3.0))
    motion = SplineMotion.stopping(start, 2.0, 4.0)
    assert motion.setpoint(2.0)[:2] == start[:2]
    q, qd, qdd = motion.setpoint(2.125)
    assert q == pytest.approx([0.125 - 2.0 * 0.125**2, 1.0 - 0.0625 + 0.125**2])
    assert qd == pytest.approx([0.5, -0.25])
    assert qdd == pytest.approx([-4.0, 2.0])
    assert not motion.is_done(2.249)
    assert motion.is_done(2.25)
    assert motion.setpoint(3.0)[0] == pytest.approx([0.125, 0.9375])
    assert SplineMotion.stopping(ArmSetpoint.resting((1.0,)), 0.0, 1.0).is_done(0.0)


def test_braking_stays_on_the_path() -> None:
    motion = started(times=[2.0], positions=[[2.0, -1.0]], velocities=[[0, 0]])
    commands(motion, 0.0, 500)
    motion.brake(4.0)
    ends = commands(motion, 0.5, 400)
    assert motion.has_braked
    assert ends[-1] == ends[-2]
    for q in ends:
        assert q[1] == pytest.approx(-0.5 * q[0], abs=EXACT)
    # The clock's factor falls by 0.004 in each of 250 ticks.
    on_path = 0.5 + sum((1.0 - 0.004 * k) * DT for k in range(1, 251))
    s = on_path / 2.0
    assert ends[-1][0] == pytest.approx(6 * s**2 - 4 * s**3, abs=EXACT)
    with pytest.raises(ControlError, match="already and stops"):
        motion.replaced(path([1.0], [[0, 0]], [[0, 0]]), 2, after=1, at=1.5, now=0.9)


@pytest.mark.parametrize(
    ("knots", "message"),
    [
        ({"times": []}, "at least one knot"),
        ({"times": [1.0, 2.0]}, r"shape \(2,\), \(1, 2\)"),
        ({"positions": [[0.0, 0.0, 0.0]]}, "2 positions"),
        ({"positions": [[0.0], [0.0, 0.0]]}, "numbers of a path"),
        ({"positions": [["a", 0.0]]}, "numbers of a path"),
        ({"accelerations": [[0.0]]}, r"must have shape \(1, 2\)"),
        ({"times": [0.0]}, "increase from 0 s"),
        ({"times": [math.nan]}, "increase from 0 s"),
        ({"positions": [[math.inf, 0.0]]}, "finite"),
        ({"velocities": [[0.1, 0.0]]}, "must end at rest"),
        ({"positions": [[0.0, 7.0]]}, "knot 0.*position of 'knee' is 7 rad"),
    ],
)
def test_impossible_paths_are_refused(knots: dict[str, Any], message: str) -> None:
    whole = {"times": [1.0], "positions": [[1, 1]], "velocities": [[0, 0]], **knots}
    with pytest.raises(ControlError, match=message):
        path(**whole)


def test_paths_faster_than_the_joints_are_refused() -> None:
    with pytest.raises(ControlError, match=r"at 1 s: the velocity of 'hip' is 4 rad/s"):
        path([1, 3], [[0, 0], [1, 0]], [[4, 0], [0, 0]])
    with pytest.raises(ControlError, match="mean velocity to the next knot of 'hip'"):
        path([1, 2], [[0, 0], [3.5, 0]], [[0, 0], [0, 0]])
