"""Control laws: what a controller does in every tick until something happens.

A running controller describes itself by a law, so that a kernel can execute its ticks
without Python.  ``Controller.update`` remains the reference, and what happens then: an
event, such as the end of a goal, is a tick that the controller executes itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from tool0.control.parameters import Pid
from tool0.control.sampler import GoalMonitor, TrajectorySampler


class TrajectoryLaw(NamedTuple):
    """Sample the desired motion; a PID and feed-forward turn errors into commands."""

    sampler: TrajectorySampler
    monitor: GoalMonitor | None
    """Of the active goal."""
    pid: Pid | None
    """None commands the desired positions."""
    feed_forward: Sequence[float]
    """Command per desired velocity, one per joint; empty without."""
    wrapping: Sequence[int]
    """The joints, by number, whose errors go the shortest way round."""


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


class IdleLaw(NamedTuple):
    """Command nothing."""


Law = TrajectoryLaw | CommandLaw | IdleLaw
