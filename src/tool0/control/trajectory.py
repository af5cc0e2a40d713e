"""Trajectory goals, states and setpoints, as immutable values.

A goal may have many thousands of points.  Checks that do not need the controller run in
the caller's thread, when the goal is created.  When the controller accepts the goal
between two ticks, it therefore does not need to examine every point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import sub
from typing import TYPE_CHECKING, final

from msgspec import Struct

from tool0.control.spline import IMPLAUSIBLE, JointSpline, Sample
from tool0.description.model import Joint, JointType, shortest_turn
from tool0.errors import GoalRejectedError
from tool0.hardware.engine import JointSelector, JointState
from tool0.protocol.goals import ToleranceOverride
from tool0.protocol.state import ArmSetpoint, JointSetpoint
from tool0.protocol.trajectories import (
    JointsMotion,
    TrajectoryPoint,
    TrajectoryState,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]

MANY = 50
"""Number of points above which numpy is faster than a Python loop."""

BLOCK = 1024
"""Number of points that numpy examines in one call.  One call takes less than a
millisecond, during which no other thread runs."""

_SHORT = 1e-9
"""Duration below which segments are examined [s], since rounding errors determine the
length of such segments."""

_TERMS = 256.0
"""Factor of the terms in a fast version of ``Segment.is_bounded``.  The terms in
``is_bounded`` add at most 32 |d| + 32 |v| T + 6 |a| T² to the position.  For T times
the speed, the sum of the terms is at most 120 |d| + 121 |v| T + 22 |a| T².  The symbol
d is the distance, and v and a are the larger velocity and the larger acceleration at
the two ends.  The factor is about twice the largest coefficient, which leaves a margin
for rounding.  Half the bound (MARGIN) leaves a margin for a rounded T and for whole
turns of a continuous joint."""

MARGIN = IMPLAUSIBLE / 2.0
"""Largest shift of positions for which it is sufficient to examine only some of the
points [rad]."""


_set = object.__setattr__  # sets the fields of frozen instances


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryGoal:
    """A trajectory and its tolerances, as in control_msgs/FollowJointTrajectoryGoal.

    A goal without points is a request to stop.

    Raises:
        GoalRejectedError: If ``points`` are not TrajectoryPoints.
    """

    points: Sequence[TrajectoryPoint]
    joint_names: Sequence[str] | None = None
    """Joints to which the points' values apply; None for the joints of the controller,
    in the controller's order."""
    stamp: float | None = None
    """Simulated time at which the trajectory starts [s]; None or 0 for the current
    time."""
    path_tolerance: Mapping[str, ToleranceOverride] = field(default_factory=dict)
    """Path tolerance per joint: a value > 0 replaces the controller's tolerance, a
    value < 0 disables the tolerance, and 0 keeps the controller's tolerance."""
    goal_tolerance: Mapping[str, ToleranceOverride] = field(default_factory=dict)
    """Goal tolerance per joint, with the same rules as for the path tolerance."""
    goal_time_tolerance: float | None = None
    """Time to arrive after the last point [s]: a value > 0 replaces the controller's
    time, a value < 0 means unlimited time, and 0 keeps the controller's time."""
    times: Sequence[float] = field(init=False, repr=False, compare=False)
    """Times of the points after the start of the trajectory [s]."""
    suspects: Sequence[int] = field(init=False, repr=False, compare=False)
    """Indices of points that may be invalid, in increasing order: the first point, and
    points with invalid times, invalid numbers or a possibly implausible segment.  If
    there are few points, all indices are included."""
    position_ranges: PositionRanges | None = field(
        init=False, repr=False, compare=False
    )
    """Ranges of the points' positions; None if there are few points."""

    def __post_init__(self) -> None:
        try:
            points = tuple(self.points)
            times = tuple([point.time_from_start for point in points])
        except (TypeError, AttributeError):
            raise GoalRejectedError(
                f"the points must be TrajectoryPoints, got {self.points!r:.80}",
                GoalRejectedError.INVALID_GOAL,
            ) from None
        suspects: Sequence[int] = range(len(points))
        ranges = None
        if len(points) >= MANY:
            suspects, ranges = _examine(points, times)
        _set(self, "points", points)
        _set(self, "times", times)
        _set(self, "suspects", suspects)
        _set(self, "position_ranges", ranges)


@final
@dataclass(frozen=True, slots=True, eq=False)
class PositionRanges:
    """Smallest and largest position of each joint in each block of points [rad | m].

    Both arrays have shape (n_blocks, n_joints), and contain NaN for blocks with invalid
    numbers.
    """

    lowest: FloatArray
    highest: FloatArray

    def blocks_beyond(self, limits: Sequence[tuple[float, float]]) -> list[int]:
        """Return the indices of blocks that may contain positions beyond the limits."""
        import numpy as np

        lower, upper = zip(*limits, strict=True)
        is_within = (self.lowest >= lower) & (self.highest <= upper)
        beyond: list[int] = np.flatnonzero(~is_within.all(axis=1)).tolist()
        return beyond


def _examine(
    points: Sequence[TrajectoryPoint], times: Sequence[float]
) -> tuple[list[int], PositionRanges]:
    """Return the indices of points that may be invalid, and the ranges of positions.

    A point that is not returned has a finite time after the previous point, and as many
    finite numbers as the first point has positions.  In the segment before a point that
    is not returned, no joint exceeds IMPLAUSIBLE.
    """
    import numpy as np

    n_joints = len(points[0].positions)
    is_sound = np.zeros(len(points), dtype=bool)
    lowest = np.full((-(-len(points) // BLOCK), n_joints), np.nan)
    highest = lowest.copy()
    for block in range(len(lowest) if n_joints else 0):
        first, end = block * BLOCK, (block + 1) * BLOCK
        before = max(first - 1, 0)  # start of the segment to the first point
        numbers = _numbers(points[before:end], n_joints)
        if numbers is None:
            continue
        lowest[block] = numbers[0, first - before :].min(axis=0)
        highest[block] = numbers[0, first - before :].max(axis=0)
        with np.errstate(all="ignore"):
            T = np.diff(times[before:end])
            distance = np.abs(np.diff(numbers[0], axis=0)).max(axis=1)
            sizes = np.abs(numbers).max(axis=2)
            position, v, a = np.maximum(sizes[:, :-1], sizes[:, 1:])
            terms = _TERMS * (distance + T * (v + T * a))
            is_sound[before + 1 : end] = (
                (T >= _SHORT) & (position + terms <= MARGIN) & (terms <= MARGIN * T)
            )
    return np.flatnonzero(~is_sound).tolist(), PositionRanges(lowest, highest)


def _numbers(points: Sequence[TrajectoryPoint], n_joints: int) -> FloatArray | None:
    """Return positions, velocities and accelerations; None if any value is invalid.

    Missing values are 0.  The shape is (3, n_points, n_joints).
    """
    import numpy as np

    absent = (0.0,) * n_joints
    try:
        numbers = np.array(
            [
                [point.positions for point in points],
                [point.velocities or absent for point in points],
                [point.accelerations or absent for point in points],
            ],
            dtype=np.float64,
        )
    except ValueError:  # the numbers of values differ
        return None
    # numpy does not detect a wrong number of positions if all points have the same
    # number.
    is_sound = numbers.shape == (3, len(points), n_joints)
    return numbers if is_sound and np.isfinite(numbers).all() else None


@final
class Setpoint(Struct, frozen=True):
    """Setpoints of one controller, at one point in time and at the end of its motion.

    For efficiency, ``Setpoint`` is a struct of immutable values: the loop creates an
    instance every eight steps.  The setpoints are computed when they are read, in the
    thread that reads them.
    """

    joint_models: tuple[Joint, ...]
    splines: tuple[JointSpline, ...]
    """Spline of each joint.  A new goal creates new splines."""
    select: JointSelector
    """Function that extracts the joints from the lists in ``measured``."""
    measured: JointState
    """The measured state at the time of the setpoint."""
    lag: float = 0.0
    """Delay of the motion relative to simulated time due to speed scaling [s]."""
    speed_scaling: float = 1.0
    """Ratio of trajectory time to simulated time."""

    @property
    def time(self) -> float:
        """Time along the splines at the time of the setpoint [s]."""
        return self.measured.time - self.lag

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of a setpoint's other sequences."""
        return tuple(joint.name for joint in self.joint_models)

    def joint_setpoints(self) -> Mapping[str, JointSetpoint]:
        """Return the setpoint of each joint."""
        time = self.time
        found: dict[str, JointSetpoint] = {}
        for joint, spline in zip(self.joint_models, self.splines, strict=True):
            now = spline.sample(time)
            found[joint.name] = JointSetpoint(now.position, now.velocity, spline.target)
        return found

    def desired_motion(self, joints: Sequence[str], time: float) -> ArmSetpoint | None:
        """Return the desired motion of ``joints`` at the simulated ``time`` [s].

        The result is None if any of ``joints`` is not a joint of the controller.
        """
        names = self.joint_names
        if not set(joints).issubset(names):
            return None
        scale = self.speed_scaling
        at = self.time + (time - self.measured.time) * scale
        samples = [self.splines[names.index(joint)].sample(at) for joint in joints]
        return ArmSetpoint(
            tuple(sample.position for sample in samples),
            tuple(scale * sample.velocity for sample in samples),
            tuple(scale * scale * sample.acceleration for sample in samples),
        )

    def target(self) -> tuple[float, ...]:
        """Return the final positions of the joints [rad | m]."""
        return tuple(spline.target for spline in self.splines)

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the desired position of a joint now and at the end [rad | m].

        The result is None if the controller does not have the joint.
        ``desired_and_target`` is much faster than ``joint_setpoints``.
        """
        for model, spline in zip(self.joint_models, self.splines, strict=True):
            if model.name == joint:
                return spline.sample(self.time).position, spline.target
        return None

    def state(self) -> TrajectoryState:
        """Return the desired motion, the actual motion and the tracking error."""
        time = self.time
        _, position, velocity, _ = self.measured
        section, segment, _ = self.splines[0].active(time)
        segment_start = segment.start - section.start
        since = segment_start + time - segment.start
        desired = joints_motion(
            [spline.sample(time) for spline in self.splines],
            time_from_start=segment_start,
        )
        actual = JointsMotion(
            positions=tuple(self.select(position)),
            velocities=tuple(self.select(velocity)),
            time_from_start=since,
        )
        return TrajectoryState(
            joint_names=self.joint_names,
            time=self.measured.time,
            desired=desired,
            actual=actual,
            error=JointsMotion(
                positions=tuple(
                    map(_error, self.joint_models, desired.positions, actual.positions)
                ),
                velocities=tuple(map(sub, desired.velocities, actual.velocities)),
                time_from_start=desired.time_from_start - since,
            ),
            speed_scaling=self.speed_scaling,
        )


def _error(joint: Joint, desired: float, actual: float) -> float:
    if joint.type is JointType.CONTINUOUS:
        return shortest_turn(actual, desired)
    return desired - actual


def joints_motion(
    samples: Sequence[Sample], *, time_from_start: float = 0.0
) -> JointsMotion:
    """Return samples of several joints as one motion."""
    return JointsMotion(
        positions=tuple(sample.position for sample in samples),
        velocities=tuple(sample.velocity for sample in samples),
        accelerations=tuple(sample.acceleration for sample in samples),
        time_from_start=time_from_start,
    )
