"""Requests about time and safety: pause, step, speed, reset, emergency stop."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, field

from tool0.requests.table import JointPositions, Request, handles
from tool0.runtime.simulation import Simulation


class Pause(Request[None], frozen=True):
    """Hold simulated time."""


class Resume(Request[None], frozen=True):
    """Let simulated time run."""


class Step(Request[float], frozen=True):
    """Run control periods while paused; the response is the time then [s]."""

    ticks: Annotated[int, Meta(ge=1, le=1_000_000)] = 1


class Run(Request[None], frozen=True):
    """Let simulated time pass; without real time this is what makes it pass."""

    duration: Annotated[float, Meta(ge=0.0)]
    """[s]"""


class SetSpeed(Request[None], frozen=True):
    """Change the speed of a simulation in real time."""

    factor: Annotated[float, Meta(gt=0.0, le=1000.0)]
    """Simulated seconds per wall second."""


class Reset(Request[None], frozen=True):
    """Return to the initial pose; goals are PREEMPTED, objects go to their start."""

    position: JointPositions = field(default_factory=dict)
    """Joint → position instead of the initial one [rad | m]."""
    keep_time: bool = False
    """Whether simulated time continues."""


class EmergencyStop(Request[None], frozen=True):
    """Brake every joint at once, or release the brakes; goals are PREEMPTED."""

    engaged: bool = True


handles(Pause, in_tick=True)(lambda sim, _: sim.loop.set_paused(True))
handles(Resume, in_tick=True)(lambda sim, _: sim.loop.set_paused(False))


@handles(Step, in_tick=True)
def _step(simulation: Simulation, request: Step) -> float:
    simulation.loop.step(request.ticks)
    return simulation.loop.time


handles(Run)(lambda sim, request: sim.loop.run(request.duration))
handles(SetSpeed, in_tick=True)(lambda sim, request: sim.loop.set_speed(request.factor))
handles(Reset, in_tick=True)(
    lambda sim, request: sim.loop.reset(request.position, request.keep_time)
)
handles(EmergencyStop, in_tick=True, urgent=True)(
    lambda sim, request: sim.core.set_stopped(request.engaged)
)
