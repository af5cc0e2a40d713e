"""Control laws: the work of a controller in each tick until an event.

A running controller describes itself by a law, so that a kernel can execute its ticks
without Python.  ``Controller.update`` remains the reference implementation, and the
controller itself executes the tick of an event, such as the end of a goal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

from tool0.control.parameters import Pid
from tool0.control.sampler import GoalMonitor, TrajectorySampler
from tool0.control.trajectory_monitor import TrajectoryMonitor
from tool0.description.drive_limits import DriveLimits
from tool0.protocol.goals import Tolerance


class TrajectoryClock(NamedTuple):
    """The time of a trajectory, which passes more slowly if its speed is reduced."""

    since: float = 0.0
    """Simulated time at which the current speed began [s]."""
    lag: float = 0.0
    """Delay behind simulated time at that moment [s]."""
    slip: float = 0.0
    """Growth of the delay per simulated second; 0 at full speed."""

    def lag_at(self, time: float) -> float:
        """Return its delay at simulated ``time`` [s], which is not before ``since``."""
        return self.lag + self.slip * (time - self.since)

    def at(self, time: float) -> float:
        """Return the trajectory's time at simulated ``time`` [s]."""
        return time - self.lag_at(time)

    def scaled(self, factor: float, now: float) -> TrajectoryClock:
        """Return the clock that runs with this factor from ``now`` [s] on."""
        return TrajectoryClock(now, self.lag_at(now), 1.0 - factor)


REAL_CLOCK = TrajectoryClock()


class TrajectoryStart(NamedTuple):
    """Rules for starting a trajectory without a goal in the next tick, as in ROS 2."""

    is_spliced: bool
    """Whether it continues the desired motion, if that has several points."""
    from_desired: bool
    """Whether it starts from the desired motion even otherwise, not from the measured
    one."""
    reads_velocity: bool
    """Whether the measured velocity is used; otherwise, 0 is assumed."""
    may_end_moving: bool
    """Whether the last point may have a velocity other than 0."""
    path: Sequence[Tolerance]
    """Tolerances on the path, one per joint."""
    at_goal: Sequence[Tolerance]
    """Tolerances at the goal, one per joint."""
    goal_time: float
    """Time to arrive after the end [s]."""
    timeout: float
    """Time after the end at which the trajectory is aborted [s]."""


class TrajectoryLaw(NamedTuple):
    """Sample the desired motion; a PID and feed-forward turn errors into commands."""

    sampler: TrajectorySampler
    monitor: GoalMonitor | TrajectoryMonitor | None
    """Monitor of the goal; a TrajectoryMonitor also works without a goal."""
    pid: Pid | None
    """PID from errors to commands; if None, the desired positions are commanded."""
    feed_forward: Sequence[float]
    """Feed-forward factors from desired velocity to command, one per joint; may be
    empty."""
    wrapping: Sequence[int]
    """Indices of the joints whose errors are wrapped to the shortest way round."""
    lead: float = 0.0
    """Time by which the commanded motion is ahead of the motion of the errors [s]."""
    clock: TrajectoryClock = REAL_CLOCK
    start: TrajectoryStart | None = None
    """Rules for the start of another trajectory.  If None, although there is a
    ``lead``, the controller starts it itself."""
    has_points: bool = False
    """Whether the motion has several points, so that another motion can continue it."""


class CommandLaw(NamedTuple):
    """Pass on one command per joint, or follow the commands with a PID."""

    values: Sequence[float]
    """The command of each joint."""
    pid: Pid | None
    """PID from values to commands; if None, the values are passed on."""
    measures_velocity: bool
    """Whether the PID compares the values with velocities instead of positions."""
    wrapping: Sequence[int]
    """Indices of the joints whose errors are wrapped to the shortest way round."""
    last_errors: list[float]
    """Errors of the last update, one per joint; updated in place."""


@final
@dataclass(slots=True)
class GripState:
    """The state of a gripper that is moving or squeezing."""

    ramp: float
    """The current setpoint [rad | m]."""
    stall_position: float
    """Position that the joint has not left since ``stall_since`` [rad | m]."""
    stall_since: float
    """Time since which the joint has stayed at ``stall_position`` [s]."""
    effort: float = 0.0
    """Commanded effort in the last tick [N·m | N]."""


class GripperLaw(NamedTuple):
    """Drive one joint to a position with bounded effort until it arrives or stalls."""

    target: float
    """Target position [rad | m]."""
    tolerance: float
    """Distance from the target below which a goal ends [rad | m]."""
    max_effort: float
    """Largest effort [N·m | N]."""
    stall_range: float
    """Largest movement of the joint that still counts as a stall [rad | m]."""
    stall_timeout: float
    """Time after which a goal ends if the joint has stalled [s]."""
    has_goal: bool
    """Whether there is a goal, which ends at the target or by a stall."""
    pid: Pid | None
    """PID from errors to efforts; if None, the target position is commanded."""
    drive_limits: DriveLimits | None
    """Limits of the drive during the goal, which slow down the ramp of the setpoint."""
    grip: GripState
    """State of the motion; updated in place."""
    position: float
    """Measured position in the last tick [rad | m]."""
    own_effort: float
    """Largest effort for goals that do not specify one [N·m | N]."""


class IdleLaw(NamedTuple):
    """Command nothing."""


ActiveLaw = TrajectoryLaw | CommandLaw | GripperLaw
Law = ActiveLaw | IdleLaw
