"""Sender that transmits the wanted motion to the program, in advance and as knots."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Final, final

from tool0.description.model import Joint
from tool0.engines.real_robot.control_program import MessageKind
from tool0.engines.real_robot.lag import MOST, LagMeter
from tool0.engines.real_robot.motion_link import Knot, MotionLink
from tool0.hardware.own_drives import WantedMotion
from tool0.protocol.state import ArmSetpoint

HORIZON: Final = 0.2
"""Time by which knots are sent in advance [s].  The arm stays on its path if tool0 is
delayed by less than this time."""
SPACING: Final = 0.012
"""Time between two knots [s].  For a time h between knots, the error of a cubic is
h⁴/384 times the fourth derivative of the motion.  A step in the acceleration between
two knots adds an error of h²/32 times the step, which is 45 µrad for 10 rad/s²."""
RENEWAL: Final = 0.04
"""Shortest time between two replacements of a curve [s], if the new curve differs from
the old curve by less than ``CLOSE``."""
CLOSE: Final = 1e-3
"""Difference between motions below which the replacement of a curve can be delayed
[rad]."""
MOST_LAG: Final = 0.04
"""Difference between the program's time and tool0's time above which tool0 sends a new
curve [s].  A real controller does not miss periods, but a simulated one can."""
STREAM_AHEAD: Final = 0.05
"""Time for which the velocities of a stream are extrapolated [s].  As a result of this
time and the program's ``EMPTY``, the arm decelerates 0.1 s after the last setpoint."""
_CHANGED: Final = 1e-7
"""Smallest difference from the sent curve at which a motion is treated as new [rad]."""
_AT_REST: Final = 1e-9
"""Speed below which a joint is at rest [rad/s]."""


@final
class CurveSender:
    """Sender that keeps the program's curve equal to the wanted motion."""

    def __init__(
        self, link: MotionLink, joints: Sequence[Joint], period: float
    ) -> None:
        """Start without a curve; ``period`` is that of the controller [s]."""
        self._link, self._period = link, period
        self._limits = [(j.limits.lower, j.limits.upper) for j in joints]
        self._spacing = max(round(SPACING / period), 1)
        self._ahead = round(HORIZON / period)
        self._every = max(round(0.004 / period), 1)
        self._sent: deque[Knot] = deque()
        """Knots that are not due yet, and the last knot that was due."""
        self._is_streaming = False
        self._quiet = 0
        """Number of periods since the last message."""
        self._renewal = round(RENEWAL / period)
        self._renewed = 0
        """Period of the program in which the whole curve was last sent."""
        self._step = 0
        """Current period of the program, counted from the knots that were sent."""
        self._most_lag = round(MOST_LAG / period)
        self._must_restart = True
        self._lag = LagMeter(period)
        self._lead = 0.0
        """Time by which the curve is ahead of the commanded motion [s].  This lead
        compensates for the robot's lag behind the curve."""

    def restart(self) -> None:
        """Send a new curve for the next motion, even after a stop."""
        self._must_restart = True
        self._sent.clear()

    def follow(
        self, wanted: WantedMotion, now: float, step: int, measured: Sequence[float]
    ) -> None:
        """Send the knots of the wanted motion that have not been sent yet.

        Args:
            wanted: The wanted motion.
            now: The time of the tick [s].
            step: Period of the program at the time ``now``.
            measured: Measured positions of the joints at the time ``now`` [rad].
        """
        self._quiet += 1
        if not wanted.is_streamed:
            present = wanted.at(now)
            self._lag.observe(present.positions, present.velocities, measured)
        now += self._lead
        step = self._continued(step)
        if wanted.is_streamed:
            self._follow_stream(wanted, now, step)
        else:
            self._follow_curve(wanted, now, step)

    def _continued(self, step: int) -> int:
        """Return the program's period for knots that continue the previous knots."""
        self._step += 1
        sent = self._sent
        rests = not sent or (sent[-1].step < self._step and _rests(sent[-1]))
        if rests or self._is_streaming:
            self._step = step
        elif abs(step - self._step) > self._most_lag:
            self._step = step
            sent.clear()
        return self._step

    def _follow_curve(self, wanted: WantedMotion, now: float, step: int) -> None:
        sent = self._sent
        while len(sent) > 1 and sent[1].step <= step:
            sent.popleft()
        if self._is_streaming or not sent:
            self._send_anew(wanted, now, step)
            return
        if self._has_changed(wanted, now, step):
            # If the motion changes continually, for example because of the speed
            # slider, the number of replacements is limited.
            is_due = step - self._renewed >= self._renewal
            if is_due or not self._is_close(wanted, now, step):
                self._send_anew(wanted, now, step)
            return
        last, end = sent[-1], step + self._ahead
        if last.step + self._spacing > end:
            return
        knots = []
        while last.step + self._spacing <= end:
            following = self._knot(wanted, now, step, last.step + self._spacing)
            if _rests_after(last, following):
                # The program rests at its last knot, and the next knot begins a new
                # curve.
                break
            knots.append(following)
            last = following
        if knots:
            self._send(knots, MessageKind.KNOT)

    def _has_changed(self, wanted: WantedMotion, now: float, step: int) -> bool:
        """Return whether the wanted motion differs from the curve that was sent."""
        sent = self._sent
        looked_at = {0, len(sent) // 2, len(sent) - 1}
        for index in looked_at:
            knot = sent[index]
            if knot.step < step:
                if not _rests(knot):
                    continue
                at = wanted.at(now)
            else:
                at = wanted.at(now + (knot.step - step) * self._period)
            if not _is_near(at.positions, knot.positions):
                return True
        last = sent[-1]
        if last.step < step and _rests(last):  # check whether the arm remains at rest
            ahead = wanted.at(now + self._ahead * self._period)
            return not _is_near(ahead.positions, last.positions)
        return False

    def _is_close(self, wanted: WantedMotion, now: float, step: int) -> bool:
        """Return whether the replacement of the curve that was sent can be delayed."""
        at = step + 2 * self._renewal
        knot = min(self._sent, key=lambda one: abs(one.step - at))
        if knot.step < step:
            return False
        soon = wanted.at(now + (knot.step - step) * self._period)
        return _is_near(soon.positions, knot.positions, CLOSE)

    def _send_anew(self, wanted: WantedMotion, now: float, step: int) -> None:
        self._is_streaming, self._renewed = False, step
        # The lead changes only at rest, since a change during a motion would cause a
        # jump.
        if _is_at_rest(wanted.at(now)):
            self._lead = min(max(self._lead + self._lag.take(), -MOST), MOST)
        knots = [self._knot(wanted, now, step, step + 1)]
        for k in range(step + self._spacing, step + self._ahead + 1, self._spacing):
            knots.append(self._knot(wanted, now, step, k))
        while len(knots) > 1 and _rests_after(knots[-2], knots[-1]):
            knots.pop()  # the program rests at its last knot
        self._sent.clear()
        self._send(knots, MessageKind.REPLACE)

    def _follow_stream(self, wanted: WantedMotion, now: float, step: int) -> None:
        if self._quiet < self._every and self._is_streaming:
            return
        self._is_streaming = True
        following = wanted.at(now + self._period)
        ahead = round(STREAM_AHEAD / self._period)
        positions, velocities = self._extrapolated(following, ahead)
        first = Knot(step + 1, following.positions, following.velocities)
        sent = self._sent
        is_same = (len(sent) == 1 and _rests(first) and _rests(sent[0])) and _is_near(
            first.positions, sent[0].positions
        )
        if is_same and not self._must_restart:
            return
        sent.clear()
        knots = [first]
        if not _rests(first):
            knots.append(Knot(step + 1 + ahead, positions, velocities))
        self._send(knots, MessageKind.REPLACE)

    def _extrapolated(
        self, start: ArmSetpoint, periods: int
    ) -> tuple[list[float], list[float]]:
        """Return the motion, extrapolated by ``periods`` within the joints' ranges."""
        positions, velocities = [], []
        for q, v, (lower, upper) in zip(
            start.positions, start.velocities, self._limits, strict=True
        ):
            end = q + v * periods * self._period
            within = min(max(end, lower), upper)
            positions.append(within)
            velocities.append(v if within == end else 0.0)
        return positions, velocities

    def _knot(self, wanted: WantedMotion, now: float, step: int, at: int) -> Knot:
        motion = wanted.at(now + (at - step) * self._period)
        return Knot(at, motion.positions, motion.velocities)

    def _send(self, knots: list[Knot], kind: MessageKind) -> None:
        if self._must_restart and kind is MessageKind.REPLACE:
            kind, self._must_restart = MessageKind.RESTART, False
        self._link.send_knots(knots, kind)
        self._sent.extend(knots)
        self._quiet = 0


def _is_at_rest(motion: ArmSetpoint) -> bool:
    return max(map(abs, motion.velocities)) < _AT_REST


def _rests(knot: Knot) -> bool:
    return max(map(abs, knot.velocities)) < _AT_REST


def _rests_after(last: Knot, following: Knot) -> bool:
    """Return whether all joints are at rest between two knots."""
    return _rests(last) and _is_near(following.positions, last.positions)


def _is_near(a: Sequence[float], b: Sequence[float], by: float = _CHANGED) -> bool:
    return max(abs(x - y) for x, y in zip(a, b, strict=True)) < by
