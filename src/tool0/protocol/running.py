"""Requests about simulated time, resets and stops."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, field

from tool0.protocol.request import JointPositions, Request


class Pause(Request[None], frozen=True):
    """Pause simulated time."""


class Resume(Request[None], frozen=True):
    """Resume simulated time."""


class Step(Request[float], frozen=True):
    """Run control periods while paused; the response is the time afterwards [s]."""

    ticks: Annotated[int, Meta(ge=1, le=1_000_000)] = 1


class Run(Request[None], frozen=True):
    """Advance simulated time; without real-time pacing, time passes only on request."""

    duration: Annotated[float, Meta(ge=0.0)]
    """Simulated time to advance by [s]."""


class SetSpeed(Request[None], frozen=True):
    """Change the speed of a simulation that runs in real time."""

    factor: Annotated[float, Meta(gt=0.0, le=1000.0)]
    """Simulated seconds per wall second."""


class Reset(Request[None], frozen=True):
    """Return robot and objects to their initial poses; goals are PREEMPTED."""

    position: JointPositions = field(default_factory=dict)
    """Joint → position that replaces the initial one [rad | m]."""
    keep_time: bool = False
    """Whether simulated time continues."""
    allow_penetration: bool = False
    """Whether links may overlap with other bodies at ``position``."""


class EmergencyStop(Request[None], frozen=True):
    """Engage all brakes at once and preempt all goals, or release the brakes."""

    is_urgent = True

    engaged: bool = True


class StopMotions(Request[None], frozen=True):
    """Stop every motion without engaging brakes; no motion resumes on its own.

    Goals are PREEMPTED, programs end, and taken arms are released.  The simulation does
    this by itself after its process was frozen for a second or more.
    """
