"""The summary of a run, which ``tool0 bringup`` prints at its end."""

from __future__ import annotations

from typing import TypedDict


class ControllerSummary(TypedDict):
    """A controller at the end of a run."""

    name: str
    """Name of the controller."""
    type: str
    """Type of the controller."""
    state: str
    """State of the controller."""
    claimed: list[str]
    """Joints that the controller claims."""


class JointSummary(TypedDict):
    """A joint at the end of a run."""

    position: float
    """Measured position [rad | m]."""
    velocity: float
    """Measured velocity [rad/s | m/s]."""
    effort: float
    """Applied effort [N·m | N]."""


class WarningSummary(TypedDict):
    """A warning about a user's file."""

    file: str
    """The file, or ``<string>``."""
    line: int | None
    """Line number, counted from 1."""
    key: str
    """Subject of the warning, such as a parameter's full name."""
    message: str
    """Description of the problem and the remedy."""


class RunSummary(TypedDict):
    """A run, as plain values for JSON."""

    engine: str
    """Physics engine."""
    sim_time: float
    """Duration [simulated s]."""
    wall_time: float
    """Duration [wall s]."""
    real_time_factor: float
    """Simulated time per wall time."""
    steps: int
    """Number of ticks."""
    overruns: int
    """Number of ticks that began more than one control period late."""
    controllers: list[ControllerSummary]
    """The loaded controllers."""
    joints: dict[str, JointSummary]
    """The joints by name."""
    max_drift: float
    """Largest drift of an uncommanded joint from its start [rad | m]."""
    warnings: list[WarningSummary]
    """Warnings about the user's files."""
