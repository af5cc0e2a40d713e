"""What a person asks of a trajectory controller, and what it answers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

from tool0.control.point_survey import MANY, PointSurvey, survey
from tool0.control.tolerances import ToleranceOverride
from tool0.errors import GoalRejectedError


@final
@dataclass(frozen=True, slots=True)
class TrajectoryPoint:
    """Where the joints should be, a time after the trajectory's start.

    Units are [rad] or [m], and those per second and per second squared.
    """

    positions: Sequence[float]
    """One per joint, in the order of the goal's joints."""
    velocities: Sequence[float] | None = None
    """None leaves them open: the motion to and from this point is linear."""
    accelerations: Sequence[float] | None = None
    """None leaves them open: the motion to and from this point is cubic at most."""
    time_from_start: float = 0.0
    """[s]"""

    def __post_init__(self) -> None:
        _set(self, "positions", _floats("positions", self.positions))
        if self.velocities is not None:
            _set(self, "velocities", _floats("velocities", self.velocities))
        if self.accelerations is not None:
            _set(self, "accelerations", _floats("accelerations", self.accelerations))
        (time,) = _floats("time_from_start", (self.time_from_start,))
        _set(self, "time_from_start", time)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryGoal:
    """A trajectory with its tolerances: control_msgs/FollowJointTrajectoryGoal.

    No points mean: stop.
    """

    points: Sequence[TrajectoryPoint]
    joint_names: Sequence[str] | None = None
    """The joints of the points' numbers; None for the controller's own, in order."""
    stamp: float | None = None
    """Simulated time at which it starts [s]; None or 0 for now."""
    path_tolerance: Mapping[str, ToleranceOverride] = field(default_factory=dict)
    """Per joint: > 0 replaces the controller's, < 0 switches it off, 0 keeps it."""
    goal_tolerance: Mapping[str, ToleranceOverride] = field(default_factory=dict)
    """Per joint, by the same rule."""
    goal_time_tolerance: float | None = None
    """Grace after the last point [s]: > 0 replaces, < 0 is unlimited, 0 keeps."""
    survey: PointSurvey | None = field(init=False, repr=False, compare=False)
    """What is known of many points, so that the tick need not look at each."""

    def __post_init__(self) -> None:
        points = tuple(self.points)
        _set(self, "points", points)
        _set(self, "survey", survey(points) if len(points) >= MANY else None)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointsMotion:
    """How several joints move: trajectory_msgs/JointTrajectoryPoint."""

    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    accelerations: tuple[float, ...] = ()
    """Empty where they are not known."""
    time_from_start: float = 0.0
    """[s]"""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryState:
    """What a trajectory controller wants, has and lacks."""

    joint_names: tuple[str, ...]
    time: float
    """Simulated time of the update that it describes [s]."""
    desired: JointsMotion
    actual: JointsMotion
    error: JointsMotion
    """desired - actual; the shortest way round for a continuous joint."""


_set = object.__setattr__  # for the fields of what is frozen once it is made


def _floats(name: str, values: Iterable[object]) -> tuple[float, ...]:
    try:
        return tuple(map(float, values))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise GoalRejectedError(
            f"{name} of a trajectory point must be numbers, got {values!r}"
        ) from None
