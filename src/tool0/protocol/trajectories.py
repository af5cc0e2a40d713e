"""Trajectories: points, state, and the requests that send trajectories."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated, Generic, final

from msgspec import Meta, field

from tool0.errors import GoalRejectedError
from tool0.protocol.goals import GoalStarted, ToleranceOverride
from tool0.protocol.motion import GripLimits
from tool0.protocol.request import Name, Request, Response


@final
@dataclass(frozen=True, slots=True)
class TrajectoryPoint:
    """Desired motion of the joints at a given time after the start of a trajectory.

    Each sequence has shape (n_joints,), in the order of the goal's joints.
    """

    positions: Sequence[float]
    """Positions [rad | m]."""
    velocities: Sequence[float] | None = None
    """Velocities [rad/s | m/s]; without velocities, the motion to and from this point
    is linear."""
    accelerations: Sequence[float] | None = None
    """Accelerations [rad/s² | m/s²]; without accelerations, the motion to and from this
    point is cubic or linear."""
    time_from_start: float = 0.0
    """Simulated time after the start of the trajectory [s]."""

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
class JointsMotion:
    """Motion of several joints, like trajectory_msgs/JointTrajectoryPoint."""

    positions: tuple[float, ...]
    """Positions [rad | m], shape (n_joints,)."""
    velocities: tuple[float, ...]
    """Velocities [rad/s | m/s], shape (n_joints,)."""
    accelerations: tuple[float, ...] = ()
    """Accelerations [rad/s² | m/s²], shape (n_joints,); empty if they are unknown."""
    time_from_start: float = 0.0
    """Time after the start of the trajectory [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryState:
    """Desired motion, measured motion and error of a controller's joints."""

    joint_names: tuple[str, ...]
    """Names of the controller's joints, in the order of the other fields."""
    time: float
    """Simulated time of the controller update that this state describes [s]."""
    desired: JointsMotion
    """Desired motion (setpoint) of the joints."""
    actual: JointsMotion
    """Measured motion of the joints."""
    error: JointsMotion
    """Error: ``desired`` minus ``actual``.  For a continuous joint, the error is the
    shortest angular distance."""
    speed_scaling: float = 1.0
    """Speed scaling: ratio of trajectory time to simulated time."""


_set = object.__setattr__  # sets the fields of frozen instances


def _floats(name: str, values: Iterable[object]) -> tuple[float, ...]:
    try:
        return tuple(map(float, values))  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        hint = ""
        if isinstance(values, int | float):
            hint = f"; for a time, write time_from_start={values}"
        raise GoalRejectedError(
            f"{name} of a trajectory point must be numbers, got {values!r:.80}{hint}"
        ) from None


Points = tuple[TrajectoryPoint, ...]

Tolerances = dict[str, ToleranceOverride]


class _OfTrajectory(Request[Response], Generic[Response], frozen=True):
    """Common fields of requests with a trajectory."""

    unchecked = ("points", "path_tolerance", "goal_tolerance")

    controller: Name
    points: Points
    """Positions, velocities and accelerations at ``time_from_start`` [s], in the order
    of ``joint_names``."""
    joint_names: tuple[str, ...] | None = None
    """Names of the points' joints; by default, the controller's joints are used."""
    stamp: float | None = None
    """Simulated time at which the trajectory starts [s]; by default, it starts
    immediately."""


class FollowTrajectory(_OfTrajectory[GoalStarted], frozen=True):
    """Send a trajectory as a goal, as an action client in ROS does.

    An empty trajectory stops the motion, but ROS 2's controllers reject it, as in ROS.
    """

    path_tolerance: Tolerances = field(default_factory=dict)
    """Joint → maximum error during the motion [rad | m]; < 0 disables the check."""
    goal_tolerance: Tolerances = field(default_factory=dict)
    """Joint → maximum error at the end of the motion [rad | m]; < 0 disables the
    check."""
    goal_time_tolerance: float | None = None
    """Time after the last point within which the goal must be reached [s]; < 0 disables
    the check."""
    grip: GripLimits | None = None
    """Limits of the gripper whose joint moves; by default, the limits of the joint
    apply."""


class CommandTrajectory(_OfTrajectory[None], frozen=True):
    """Send a trajectory without a goal; an empty trajectory stops the motion."""

    points: Points = ()


class ScaleTrajectory(Request[None], frozen=True):
    """Scale the speed of a controller's trajectories.

    The request corresponds to ``speed_scaling_input`` in ROS 2.  Tolerances are checked
    against the scaled trajectory.
    """

    controller: Name
    factor: Annotated[float, Meta(ge=0.0)]
    """Ratio of trajectory time to simulated time; 0 pauses the trajectory."""
