"""Motions of an arm that are known in advance: paths, ramps to rest and holding."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, final

from tool0.control.law import REAL_CLOCK, TrajectoryClock, TrajectoryLaw
from tool0.control.sampler import TrajectorySampler
from tool0.control.spline import (
    JointSpline,
    Knots,
    Motion,
    Sample,
    Segment,
    SplineSection,
    along,
    hold,
    section_through,
)
from tool0.description.model import Joint
from tool0.errors import ControlError
from tool0.protocol.state import ArmSetpoint

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    FloatArray = NDArray[np.float64]

CONTINUITY = 1e-6
"""Largest jump between the setpoint and the start of a path [rad, rad/s]."""
_ROUNDING = 1e-9
"""Tolerance for rounding errors of times [s]."""

Row = Sequence[float]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ArmPath:
    """Joint motions at the knots of a path; the arrays have shape (n_knots, n_joints).

    The knots are connected by cubic polynomials or, if accelerations are given, by
    quintic polynomials.
    """

    times: Sequence[float]
    """Times of the knots after the start of the path [s], in increasing order; the
    first time may be 0."""
    positions: Sequence[Row]
    """Joint positions at the knots [rad]."""
    velocities: Sequence[Row]
    """Joint velocities at the knots [rad/s]."""
    accelerations: Sequence[Row] = ()
    """Joint accelerations at the knots [rad/s²]; empty if no accelerations are
    given."""

    @property
    def duration(self) -> float:
        """Time of the last knot [s]."""
        return self.times[-1]

    def motion(self, joint: int, number: int) -> Motion:
        """Return the motion of a joint at a knot; both are given by their indices."""
        rows = self.accelerations
        acceleration = rows[number][joint] if rows else None
        return Motion(
            self.positions[number][joint], self.velocities[number][joint], acceleration
        )

    @staticmethod
    def of(
        joints: Sequence[Joint],
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike,
        accelerations: ArrayLike = (),
    ) -> ArmPath:
        """Return a path that the joints can follow, or raise ControlError.

        Positions, velocities and the mean velocities between knots are checked against
        the joints' limits.  A path may start slightly beyond a limit and lead back into
        the allowed range (``JointLimits.range_from``).
        """
        import numpy as np

        given = times, positions, velocities, accelerations
        try:
            T, q, qd, qdd = (np.asarray(item, dtype=np.float64) for item in given)
        except (TypeError, ValueError, OverflowError) as error:
            raise ControlError(f"the numbers of a path: {error}") from None
        shape = (T.size, len(joints))
        if not T.size or T.ndim != 1 or not q.shape == qd.shape == shape:
            raise ControlError(
                "a path needs at least one knot, and for each of them a time, and "
                f"{len(joints)} positions and velocities; got arrays of shape "
                f"{T.shape}, {q.shape} and {qd.shape}"
            )
        if qdd.size and qdd.shape != shape:
            raise ControlError(
                f"the accelerations of a path must have shape {shape}, got {qdd.shape}"
            )
        _check(joints, T, q, qd, qdd)
        return ArmPath(
            times=T.tolist(),
            positions=q.tolist(),
            velocities=qd.tolist(),
            accelerations=qdd.tolist(),
        )


def _check(
    joints: Sequence[Joint],
    times: FloatArray,
    q: FloatArray,
    qd: FloatArray,
    qdd: FloatArray,
) -> None:
    import numpy as np

    finite = all(np.isfinite(item).all() for item in (times, q, qd, qdd))
    increasing = (np.diff(times) > 0.0).all()
    if not (finite and increasing and times[0] >= 0.0 and times[-1] > 0.0):
        raise ControlError(
            "the times of a path must increase from 0 s or later, and all numbers "
            "be finite"
        )
    if np.any(qd[-1]):
        raise ControlError(
            f"a path must end at rest, its last velocities are {qd[-1].tolist()}"
        )
    ranges = [
        joint.limits.range_from(start)
        for joint, start in zip(joints, q[0].tolist(), strict=True)
    ]
    lower, upper = np.array(ranges).T
    fastest = np.array([joint.max_velocity for joint in joints]) * (1.0 + 1e-6)
    mean = np.diff(q, axis=0) / np.diff(times)[:, None]
    for what, unit, values, is_wrong in (
        ("position", "rad", q, (q < lower - CONTINUITY) | (q > upper + CONTINUITY)),
        ("velocity", "rad/s", qd, np.abs(qd) > fastest),
        ("mean velocity to the next knot", "rad/s", mean, np.abs(mean) > fastest),
    ):
        if is_wrong.any():
            knot, k = np.argwhere(is_wrong)[0].tolist()
            raise ControlError(
                f"knot {knot} of the path, at {times[knot]:g} s: the {what} of "
                f"'{joints[k].name}' is {values[knot, k]:.6g} {unit}, beyond its "
                f"limits {_limits_text(joints[k], what)}"
            )


def _limits_text(joint: Joint, what: str) -> str:
    limits = joint.limits
    if what == "position":
        return f"[{limits.lower:.6g}, {limits.upper:.6g}]"
    return f"±{joint.max_velocity:.6g}"


class _Course(NamedTuple):
    """A path's number, start time and duration."""

    number: int
    start: float
    """Start time of the path, in the clock's time [s]."""
    duration: float
    """Duration of the path [s]."""


@final
class SplineMotion:
    """Motion of joints along splines, which the kernel can also execute.

    The splines use the time of a clock that runs more slowly than simulated time while
    the speed is scaled down.
    """

    def __init__(
        self,
        mode: Literal["hold", "path", "stop"],
        splines: Sequence[JointSpline],
        *,
        end: float,
        clock: TrajectoryClock = REAL_CLOCK,
        speed_scaling: float = 1.0,
        courses: tuple[_Course, ...] = (),
    ) -> None:
        self.mode = mode
        self._splines = tuple(splines)
        self._end = end
        """Time at which the motion comes to rest, in the clock's time [s]."""
        self._clock = clock
        self.speed_scaling = speed_scaling
        """Rate of the clock relative to simulated time."""
        self._courses = courses
        self._braking = 0.0
        """Rate at which the clock slows down [1/s]; 0 if the clock is not being
        stopped."""
        self._brake_factor = 1.0
        self._follow(self._splines)

    @staticmethod
    def holding(positions: Sequence[float], now: float) -> SplineMotion:
        """Return a motion that rests at ``positions`` [rad]."""
        return SplineMotion("hold", [hold(now, q) for q in positions], end=now)

    @staticmethod
    def stopping(start: ArmSetpoint, now: float, deceleration: float) -> SplineMotion:
        """Return a ramp of constant decelerations that stops all joints simultaneously.

        ``deceleration`` applies to the leading joint [rad/s²].
        """
        duration = max(map(abs, start.velocities)) / deceleration
        splines = []
        for q, qd in zip(start.positions, start.velocities, strict=True):
            if duration > 0.0 and qd != 0.0:
                terms = (q, qd, -0.5 * qd / duration, 0.0, 0.0, 0.0)
                splines.append(along(Segment.of(now, now + duration, terms)))
            else:
                splines.append(hold(now, q))
        return SplineMotion("stop", splines, end=now + duration)

    @staticmethod
    def along(
        path: ArmPath, number: int, start: ArmSetpoint, now: float, factor: float
    ) -> SplineMotion:
        """Return the motion along a path that begins at the setpoint ``start``.

        ``factor`` scales the speed, starting at ``now`` [s].

        Raises:
            ControlError: If the path does not begin at ``start``.
        """
        scale = factor or 1.0
        origins = [
            Motion(q, qd / scale, qdd / scale / scale)
            for q, qd, qdd in zip(*start, strict=True)
        ]
        splines = [
            JointSpline((_section(path, k, origin, now),))
            for k, origin in enumerate(origins)
        ]
        return SplineMotion(
            "path",
            splines,
            end=now + path.duration,
            clock=TrajectoryClock(now, 0.0, 1.0 - factor),
            speed_scaling=factor,
            courses=(_Course(number, now, path.duration),),
        )

    def replaced(
        self, path: ArmPath, number: int, *, after: int, at: float, now: float
    ) -> None:
        """Replace path number ``after``, starting at the time ``at`` along it [s].

        Raises:
            ControlError: If the time ``at`` has passed, the old path is not being
                executed, or the new path does not begin with the old path's motion at
                the time ``at``.
        """
        time = self._clock.at(now)
        k = next((k for k, c in enumerate(self._courses) if c.number == after), None)
        if k is None:
            numbers = ", ".join(str(course.number) for course in self._courses)
            raise ControlError(
                f"path {after} is not executed, so none can follow it; executed: "
                f"{numbers or 'none'}"
            )
        leave = self._courses[k].start + at
        if leave < time or self._braking:
            passed = time - self._courses[k].start
            raise ControlError(
                f"path {after} is at {passed:.6f} s already"
                f"{' and stops' if self._braking else ''}; it cannot be replaced from "
                f"{at:.6f} s on"
            )
        if k + 1 < len(self._courses) and leave > self._courses[k + 1].start:
            following = self._courses[k + 1]
            raise ControlError(
                f"path {following.number} replaces path {after} from "
                f"{following.start - self._courses[k].start:.6f} s on; give `after` "
                f"{following.number}, or an earlier time"
            )
        splines = []
        for joint, old in enumerate(self._splines):
            section = _section(path, joint, Motion(*old.sample(leave)), leave)
            splines.append(old.followed_by(section, time, leave))
        kept = self._courses[self._active(time) : k + 1]
        self._courses = (*kept, _Course(number, leave, path.duration))
        self._end = leave + path.duration
        self._splines = tuple(splines)
        self._follow(self._splines)

    def brake(self, rate: float) -> None:
        """Slow the clock down to a stop at ``rate`` [1/s].

        The arm stays on the path.
        """
        self._braking = rate

    @property
    def has_braked(self) -> bool:
        """Whether the clock has been stopped permanently."""
        return self._brake_factor == 0.0

    # ---- the tick -------------------------------------------------------------------

    def update(self, time: float, period: float, factor: float) -> Sequence[float]:
        """Return the positions at the end of the tick that starts at ``time`` [s].

        ``factor`` is the speed factor of the control box.  The factor does not scale
        ramps to rest.
        """
        if self._braking:
            self._brake_factor = max(0.0, self._brake_factor - self._braking * period)
        if self.mode == "path":
            used = factor * self._brake_factor
            if used != self.speed_scaling:
                self._clock = self._clock.scaled(used, time)
                self.speed_scaling = used
        ahead = self._clock.at(time) + period * self.speed_scaling
        sampler = self._sampler
        if ahead >= sampler.next_change:
            sampler.advance(ahead)
        return sampler.desired(ahead)[0]

    def law(self, period: float, factor: float) -> TrajectoryLaw | None:
        """Return the law equivalent to ``update``, or None while the speed changes."""
        if self._braking or (self.mode == "path" and factor != self.speed_scaling):
            return None
        lead = period * self.speed_scaling
        return TrajectoryLaw(
            self._sampler, None, None, (), (), lead=lead, clock=self._clock
        )

    def _follow(self, splines: Sequence[JointSpline]) -> None:
        self._sampler = TrajectorySampler(splines, -math.inf)

    # ---- between ticks --------------------------------------------------------------

    @property
    def splines(self) -> tuple[JointSpline, ...]:
        """The spline of each joint, in the clock's time."""
        return self._splines

    def lag(self, now: float) -> float:
        """Return the delay of the clock relative to simulated time at ``now`` [s]."""
        return self._clock.lag_at(now)

    def setpoint(self, now: float) -> ArmSetpoint:
        """Return the motion at simulated time ``now`` [s]."""
        time, scale = self._clock.at(now), self.speed_scaling
        samples: list[Sample] = [spline.sample(time) for spline in self._splines]
        return ArmSetpoint(
            tuple(sample.position for sample in samples),
            tuple(scale * sample.velocity for sample in samples),
            tuple(scale * scale * sample.acceleration for sample in samples),
        )

    def is_done(self, now: float) -> bool:
        """Return whether the end of the motion has been commanded by ``now`` [s]."""
        return self.has_braked or self._clock.at(now) >= self._end - _ROUNDING

    def progress(self, now: float) -> tuple[int, float] | None:
        """Return the active path's number and the time along it [s], or None."""
        if not self._courses:
            return None
        time = self._clock.at(now)
        course = self._courses[self._active(time)]
        passed = max(time - course.start, 0.0)  # the path may start later
        return course.number, min(passed, course.duration)

    def _active(self, time: float) -> int:
        """Return the index of the course at the clock's ``time`` [s]."""
        started = [k for k, c in enumerate(self._courses) if c.start <= time]
        return started[-1] if started else 0


def _section(path: ArmPath, joint: int, origin: Motion, start: float) -> SplineSection:
    """Return a joint's motion along a path that starts at ``start`` [s].

    ``origin`` is the motion at the start.  A knot at time 0 replaces ``origin``; the
    two must agree within ``CONTINUITY``.
    """
    first = 0
    if path.times[0] == 0.0:
        knot = path.motion(joint, 0)
        before, at = origin.velocity or 0.0, knot.velocity or 0.0
        jump = abs(knot.position - origin.position)
        if not (jump <= CONTINUITY and abs(at - before) <= CONTINUITY):
            raise ControlError(
                f"a path must begin with the setpoint: joint {joint} is at "
                f"{origin.position:.9f} rad with {before:.9f} rad/s, and its first "
                f"knot at {knot.position:.9f} rad with {at:.9f} rad/s"
            )
        origin, first = knot, 1
    knots = Knots(path.times, lambda number: path.motion(joint, number))
    return section_through(start, knots, (start, origin), first=first, suspects=())
