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
    """Run control periods while paused; the response is the new time [s]."""

    ticks: Annotated[int, Meta(ge=1, le=1_000_000)] = 1


class Run(Request[None], frozen=True):
    """Advance simulated time.

    If the simulation does not run in real time, simulated time passes only on request.
    """

    duration: Annotated[float, Meta(ge=0.0)]
    """Duration of the advance [simulated s]."""


class SetSpeed(Request[None], frozen=True):
    """Change the speed of a simulation that runs in real time."""

    factor: Annotated[float, Meta(gt=0.0, le=1000.0)]
    """Simulated seconds per wall second."""


class Reset(Request[None], frozen=True):
    """Return the robot and the objects to their initial poses; preempt all goals."""

    position: JointPositions = field(default_factory=dict)
    """Joint → position that replaces the initial position [rad | m]."""
    keep_time: bool = False
    """Whether simulated time continues instead of restarting at 0."""
    allow_penetration: bool = False
    """Whether links are allowed to overlap with other bodies at ``position``."""


class EmergencyStop(Request[None], frozen=True):
    """Engage all brakes immediately and preempt all goals, or release the brakes."""

    is_urgent = True

    engaged: bool = True


class StopMotions(Request[None], frozen=True):
    """Stop every motion without engaging the brakes; no motion resumes automatically.

    Goals are PREEMPTED, programs end, and taken arms are released.  Commanded speeds
    become 0, and joints that move to commanded positions hold, but commanded efforts
    stay in effect.  The simulation stops all motions automatically after its process
    has been frozen for 1 s or more.
    """
