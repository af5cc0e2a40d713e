"""Control laws: what a controller does in every tick until something happens.

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
from tool0.control.watch import TrajectoryWatch
from tool0.hardware.limits import DriveLimits


class TrajectoryClock(NamedTuple):
    """The time of a trajectory, which passes more slowly if its speed is scaled."""

    since: float = 0.0
    """Since when it passes as it does now, in simulated time [s]."""
    lag: float = 0.0
    """How far it was behind then [s]."""
    slip: float = 0.0
    """How much it falls behind in a simulated second [s]; 0 at full speed."""

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


class TrajectoryLaw(NamedTuple):
    """Sample the desired motion; a PID and feed-forward turn errors into commands."""

    sampler: TrajectorySampler
    monitor: GoalMonitor | TrajectoryWatch | None
    """Of the active goal; what watches all joints also does so without a goal."""
    pid: Pid | None
    """None commands the desired positions."""
    feed_forward: Sequence[float]
    """Command per desired velocity, one per joint; empty without."""
    wrapping: Sequence[int]
    """The joints, by number, whose errors go the shortest way round."""
    lead: float = 0.0
    """By how much the commanded motion is ahead of what errors are against [s]."""
    clock: TrajectoryClock = REAL_CLOCK


class CommandLaw(NamedTuple):
    """Pass one command per joint on, or follow it by a PID."""

    values: Sequence[float]
    """One per joint."""
    pid: Pid | None
    """None passes the values on."""
    measures_velocity: bool
    """Whether the PID compares the values with velocities, not with positions."""
    wrapping: Sequence[int]
    """The joints, by number, whose errors go the shortest way round."""
    last_errors: list[float]
    """Those of the last update, one per joint; updated in place."""


@final
@dataclass(slots=True)
class Grip:
    """What changes while a gripper moves and squeezes."""

    ramp: float
    """The position to be at now [rad | m]."""
    stall_position: float
    """Where the joint has not moved from [rad | m] …"""
    stall_since: float
    """… since then [s]."""
    effort: float = 0.0
    """Of the last tick [N·m | N]."""


class GripperLaw(NamedTuple):
    """Drive one joint to a position with bounded effort until it arrives or stalls."""

    target: float
    """[rad | m]"""
    tolerance: float
    """[rad | m]"""
    max_effort: float
    """[N·m | N]"""
    stall_range: float
    """A movement of less than that is none [rad | m]."""
    stall_timeout: float
    """[s]"""
    has_goal: bool
    """Whether a goal ends at the target, or by a stall."""
    pid: Pid | None
    """None commands the target."""
    drive_limits: DriveLimits | None
    """Of the goal: they slow the ramp down."""
    grip: Grip
    """Updated in place."""


class IdleLaw(NamedTuple):
    """Command nothing."""


ActiveLaw = TrajectoryLaw | CommandLaw | GripperLaw
Law = ActiveLaw | IdleLaw
