"""Knots of a curve: what is sent, and when it is sent anew."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import cast

import pytest

import tool0
from tool0.description.loading import load_description
from tool0.description.parts import find_arms
from tool0.engines.real_robot.control_program import MessageKind
from tool0.engines.real_robot.curve import HORIZON, SPACING, CurveSender
from tool0.engines.real_robot.motion_link import Knot, MotionLink
from tool0.hardware.own_drives import WantedMotion
from tool0.protocol.state import ArmSetpoint

PERIOD = 0.002
Sent = list[tuple[MessageKind, list[Knot]]]


class Link:
    """Keeps what is sent."""

    def __init__(self) -> None:
        self.sent: Sent = []

    def send_knots(self, knots: Sequence[Knot], first: MessageKind) -> None:
        self.sent.append((first, list(knots)))


def swing(time: float, speed: float = 1.0) -> ArmSetpoint:
    """A motion from 0 to 1 rad and back, which rests before 0 and after 2 s."""
    t = min(max(time, 0.0), 2.0)
    q = 0.5 * (1.0 - math.cos(math.pi * t)) * speed
    v = 0.5 * math.pi * math.sin(math.pi * t) * speed if 0.0 < time < 2.0 else 0.0
    rest = (0.0,) * 5
    return ArmSetpoint((q, *rest), (v, *rest), (0.0,) * 6)


def sender() -> tuple[CurveSender, Sent]:
    model = load_description(tool0.DescriptionConfig(arm="ur5e")).model
    (arm,) = find_arms(model).values()
    link = Link()
    return CurveSender(cast(MotionLink, link), arm.joints, PERIOD), link.sent


def follow(curve: CurveSender, wanted: WantedMotion, tick: int, step: int) -> None:
    """Follow for a tick, with an arm that does so without delay."""
    now = tick * PERIOD
    curve.follow(wanted, now, step, wanted.at(now).positions)


def test_a_motion_is_sent_once_and_ahead_of_time() -> None:
    curve, sent = sender()
    wanted = WantedMotion(swing)
    for tick in range(1200):
        follow(curve, wanted, tick, 100 + tick)
    first, *others = sent
    assert first[0] is MessageKind.RESTART
    assert {kind for kind, _ in others} == {MessageKind.KNOT}
    knots = [knot for _, part in sent for knot in part]
    for before, after in pairwise(knots):
        assert before.step < after.step
    for step, positions, velocities in knots:
        state = swing((step - 100) * PERIOD)
        assert positions == pytest.approx(state.positions)
        assert velocities == pytest.approx(state.velocities)
    assert knots[-1].velocities == (0.0,) * 6
    assert (knots[-1].step - 100) * PERIOD < 2.0 + 2.0 * SPACING
    horizon = max(knots_ahead(sent))
    assert HORIZON - SPACING <= horizon * PERIOD <= HORIZON


def knots_ahead(sent: Sent) -> list[int]:
    """Return how far ahead the first curve went."""
    return [sent[0][1][-1].step - 100]


def test_another_motion_replaces_the_rest_of_the_curve() -> None:
    curve, sent = sender()
    for tick in range(100):
        follow(curve, WantedMotion(swing), tick, tick)
    sent.clear()
    halt = swing(100 * PERIOD).positions
    still = ArmSetpoint(halt, (0.0,) * 6, (0.0,) * 6)
    follow(curve, WantedMotion(lambda time: still), 100, 100)
    ((kind, knots),) = sent
    assert kind is MessageKind.REPLACE
    assert [knot.step for knot in knots] == [101]  # it rests there


def test_a_motion_that_changes_all_the_time_is_renewed_now_and_then() -> None:
    curve, sent = sender()
    for tick in range(500):
        slow = 1.0 - 1e-4 * tick
        wanted = WantedMotion(lambda time, slow=slow: swing(time, slow))
        follow(curve, wanted, tick, tick)
    renewals = [kind for kind, _ in sent if kind is MessageKind.REPLACE]
    assert 20 <= len(renewals) <= 60  # 1 s, at most one in 20 ms


def test_a_stream_goes_on_for_a_moment_only() -> None:
    curve, sent = sender()
    speed = ArmSetpoint((0.1,) * 6, (0.5,) * 6, (0.0,) * 6)
    follow(curve, WantedMotion(lambda time: speed, is_streamed=True), 0, 10)
    ((kind, (first, last)),) = sent
    assert kind is MessageKind.RESTART
    assert first.step == 11
    assert (last.step - first.step) * PERIOD == pytest.approx(0.05)
    assert last.positions == pytest.approx([0.125] * 6)


def test_a_program_that_lost_periods_gets_its_curve_again() -> None:
    curve, sent = sender()
    for tick in range(100):
        follow(curve, WantedMotion(swing), tick, tick)
    sent.clear()
    for tick in range(100, 110):
        follow(curve, WantedMotion(swing), tick, tick - 30)
    assert sent[0][0] is MessageKind.REPLACE
    assert sent[0][1][0].step == 71


def test_a_robot_that_is_late_gets_the_next_motion_earlier() -> None:
    """A delay of 10 ms is measured in one motion, and made up for in the next."""
    curve, sent = sender()

    def later(start: float) -> WantedMotion:
        return WantedMotion(lambda time: swing(time - start), key=(start,))

    first, second = later(0.0), later(3.0)
    for tick in range(2000):
        wanted = first if tick < 1400 else second
        now = tick * PERIOD
        curve.follow(wanted, now, tick, wanted.at(now - 0.01).positions)
    knots = [knot for _, part in sent for knot in part if knot.step > 1600]
    assert knots
    for step, positions, _ in knots:
        ahead = second.at(step * PERIOD + 0.01).positions
        assert positions == pytest.approx(ahead, abs=2e-4)


def test_a_motion_that_starts_later_is_sent_at_once() -> None:
    """Its knots are there when it starts, also those before it, at rest."""
    curve, sent = sender()
    resting = WantedMotion(lambda time: swing(0.0))
    later = WantedMotion(lambda time: swing(time - 0.3))
    for tick in range(50):
        follow(curve, resting, tick, 100 + tick)
    sent.clear()
    for tick in range(50, 151):
        follow(curve, later, tick, 100 + tick)
        started = [k for _, part in sent for k in part if k.velocities[0] > 0.0]
        if started:
            break
    assert 0.3 - tick * PERIOD > HORIZON - 2.0 * SPACING  # as soon as it is within
    (kind, knots) = sent[-1]
    assert kind is MessageKind.REPLACE
    assert knots[0].velocities == knots[1].velocities == (0.0,) * 6
    assert knots[-1].velocities[0] > 0.0
