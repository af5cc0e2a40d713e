"""Control laws: a controller's computations in each tick, until an event occurs.

A running controller provides a law, so that a kernel can execute the controller's ticks
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
    """The clock of a trajectory, which runs more slowly if the speed is reduced."""

    since: float = 0.0
    """Simulated time at which the current speed was set [s]."""
    lag: float = 0.0
    """Delay of the clock relative to simulated time at the time ``since`` [s]."""
    slip: float = 0.0
    """Increase of the delay per second of simulated time; 0 at full speed."""

    def lag_at(self, time: float) -> float:
        """Return the delay [s] at simulated ``time`` [s], at or after ``since``."""
        return self.lag + self.slip * (time - self.since)

    def at(self, time: float) -> float:
        """Return the trajectory's time at simulated ``time`` [s]."""
        return time - self.lag_at(time)

    def scaled(self, factor: float, now: float) -> TrajectoryClock:
        """Return a clock that runs at the speed ``factor`` after ``now`` [s]."""
        return TrajectoryClock(now, self.lag_at(now), 1.0 - factor)


REAL_CLOCK = TrajectoryClock()


class TrajectoryStart(NamedTuple):
    """The ROS 2 rules for starting, in the next tick, a trajectory that has no goal."""

    is_spliced: bool
    """Whether the trajectory continues the desired motion if that motion has several
    points."""
    from_desired: bool
    """Whether a trajectory that does not continue the desired motion still starts from
    it, rather than from the measured motion."""
    reads_velocity: bool
    """Whether the measured velocity is used; otherwise, a velocity of 0 is assumed."""
    may_end_moving: bool
    """Whether the last point may have a nonzero velocity."""
    path: Sequence[Tolerance]
    """Tolerances on the path, one per joint."""
    at_goal: Sequence[Tolerance]
    """Tolerances at the goal, one per joint."""
    goal_time: float
    """Time that the joints may take to arrive after the end of the trajectory [s]."""
    timeout: float
    """Time after the end of the trajectory at which it is aborted [s]."""


class TrajectoryLaw(NamedTuple):
    """Samples the desired motion and commands it, or follows it with a PID."""

    sampler: TrajectorySampler
    monitor: GoalMonitor | TrajectoryMonitor | None
    """Monitor of the goal; a TrajectoryMonitor can also be used without a goal."""
    pid: Pid | None
    """PID from errors to commands; if None, the desired positions are commanded."""
    feed_forward: Sequence[float]
    """Feed-forward factors from desired velocity to command, one per joint; the
    sequence may be empty."""
    wrapping: Sequence[int]
    """Indices of the joints with errors that are wrapped to the shortest rotation."""
    lead: float = 0.0
    """Time by which the commanded motion leads the motion that determines the errors
    [s]."""
    clock: TrajectoryClock = REAL_CLOCK
    start: TrajectoryStart | None = None
    """Rules for the start of another trajectory.  If the rules are None although
    ``lead`` is not 0, the controller starts the trajectory."""
    has_points: bool = False
    """Whether the motion has several points, so that another motion can continue it."""


class CommandLaw(NamedTuple):
    """Forwards one command per joint, or follows the commands with a PID."""

    values: Sequence[float]
    """The command of each joint."""
    pid: Pid | None
    """PID from values to commands; if None, the values are forwarded."""
    measures_velocity: bool
    """Whether the PID compares the values with velocities instead of positions."""
    wrapping: Sequence[int]
    """Indices of the joints with errors that are wrapped to the shortest rotation."""
    last_errors: list[float]
    """Errors of the last update, one per joint; the list is updated in place."""


@final
@dataclass(slots=True)
class GripState:
    """The state of a gripper that is moving or squeezing."""

    ramp: float
    """The current setpoint [rad | m]."""
    stall_position: float
    """Position at which the joint has stayed since ``stall_since`` [rad | m]."""
    stall_since: float
    """Time since which the joint has stayed at ``stall_position`` [s]."""
    effort: float = 0.0
    """Commanded effort in the last tick [N·m | N]."""


class GripperLaw(NamedTuple):
    """Moves one joint to a position with limited effort until it arrives or stalls."""

    target: float
    """Target position [rad | m]."""
    tolerance: float
    """Distance from the target below which a goal ends [rad | m]."""
    max_effort: float
    """Largest effort [N·m | N]."""
    stall_range: float
    """Largest movement of the joint that is still considered a stall [rad | m]."""
    stall_timeout: float
    """Time after which a goal ends if the joint has stalled [s]."""
    has_goal: bool
    """Whether there is a goal.  A goal ends when the joint reaches the target or
    stalls."""
    pid: Pid | None
    """PID from errors to efforts; if None, the target position is commanded."""
    drive_limits: DriveLimits | None
    """Limits of the drive during the goal; they limit the speed of the setpoint's
    ramp."""
    grip: GripState
    """State of the motion, which is updated in place."""
    position: float
    """Measured position in the last tick [rad | m]."""
    own_effort: float
    """Largest effort for goals that do not specify an effort [N·m | N]."""


class IdleLaw(NamedTuple):
    """Commands no joints."""


ActiveLaw = TrajectoryLaw | CommandLaw | GripperLaw
Law = ActiveLaw | IdleLaw
