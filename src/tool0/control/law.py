"""Control laws: the work of a controller in every tick until an event.

A running controller describes itself by a law, so that a kernel can execute its ticks
without Python.  ``Controller.update`` remains the reference, and what happens then: an
event, such as the end of a goal, is a tick that the controller executes itself.
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
    """The time of a trajectory, which passes more slowly if its speed is scaled."""

    since: float = 0.0
    """Simulated time at which the present speed began [s]."""
    lag: float = 0.0
    """Delay behind simulated time then [s]."""
    slip: float = 0.0
    """Growth of the delay per simulated second [s]; 0 at full speed."""

    def lag_at(self, time: float) -> float:
        """Return how far it is behind simulated ``time`` [s], from ``since`` on."""
        return self.lag + self.slip * (time - self.since)

    def at(self, time: float) -> float:
        """Return the trajectory's time at simulated ``time`` [s]."""
        return time - self.lag_at(time)

    def scaled(self, factor: float, now: float) -> TrajectoryClock:
        """Return the clock that passes with this factor from ``now`` [s] on."""
        return TrajectoryClock(now, self.lag_at(now), 1.0 - factor)


REAL_CLOCK = TrajectoryClock()


class TrajectoryStart(NamedTuple):
    """How a trajectory without a goal starts with the coming tick, as in ROS 2."""

    is_spliced: bool
    """Whether it follows the desired motion, if that has several points."""
    from_desired: bool
    """Whether it also starts there otherwise, and not with the measured motion."""
    reads_velocity: bool
    """Whether the measured motion has a velocity; otherwise it is 0."""
    may_end_moving: bool
    """Whether its last point may have velocities."""
    path: Sequence[Tolerance]
    """One tolerance per joint on the way."""
    at_goal: Sequence[Tolerance]
    """One tolerance per joint at the end."""
    goal_time: float
    """Grace after the end [s]."""
    timeout: float
    """When it is given up after the end [s]."""


class TrajectoryLaw(NamedTuple):
    """Sample the desired motion; a PID and feed-forward turn errors into commands."""

    sampler: TrajectorySampler
    monitor: GoalMonitor | TrajectoryMonitor | None
    """Monitor of the goal; a TrajectoryMonitor also works without one."""
    pid: Pid | None
    """PID from errors to commands; None commands the desired positions."""
    feed_forward: Sequence[float]
    """Command per desired velocity, one per joint; empty without."""
    wrapping: Sequence[int]
    """The joints, by number, whose errors go the shortest way round."""
    lead: float = 0.0
    """Time by which commands are ahead of the motion that errors refer to [s]."""
    clock: TrajectoryClock = REAL_CLOCK
    start: TrajectoryStart | None = None
    """How another trajectory starts; None with a lead leaves that to the controller."""
    has_points: bool = False
    """Whether the motion has several points: another one may follow it."""


class CommandLaw(NamedTuple):
    """Pass one command per joint on, or follow it by a PID."""

    values: Sequence[float]
    """The command of each joint."""
    pid: Pid | None
    """PID from values to commands; None passes the values on."""
    measures_velocity: bool
    """Whether the PID compares the values with velocities, not with positions."""
    wrapping: Sequence[int]
    """The joints, by number, whose errors go the shortest way round."""
    last_errors: list[float]
    """Errors of the last update, one per joint; updated in place."""


@final
@dataclass(slots=True)
class GripState:
    """The state of a gripper that moves and squeezes."""

    ramp: float
    """The present setpoint [rad | m]."""
    stall_position: float
    """The position that the joint has not left [rad | m] …"""
    stall_since: float
    """… since this time [s]."""
    effort: float = 0.0
    """Effort in the last tick [N·m | N]."""


class GripperLaw(NamedTuple):
    """Drive one joint to a position with bounded effort until it arrives or stalls."""

    target: float
    """Target position [rad | m]."""
    tolerance: float
    """Largest distance from the target at which a goal ends [rad | m]."""
    max_effort: float
    """Largest effort [N·m | N]."""
    stall_range: float
    """Largest movement of a joint that counts as stalled [rad | m]."""
    stall_timeout: float
    """Time after which a stalled goal ends [s]."""
    has_goal: bool
    """Whether a goal ends at the target, or by a stall."""
    pid: Pid | None
    """PID from errors to efforts; None commands the target."""
    drive_limits: DriveLimits | None
    """Limits of the drive during the goal; they slow the ramp down."""
    grip: GripState
    """The state; updated in place."""
    position: float
    """The position in the last tick [rad | m]."""
    own_effort: float
    """Largest effort of a goal that names none [N·m | N]."""


class IdleLaw(NamedTuple):
    """Command nothing."""


ActiveLaw = TrajectoryLaw | CommandLaw | GripperLaw
Law = ActiveLaw | IdleLaw
