"""Publication of snapshots of a core, with the fields that subscribers need."""

from __future__ import annotations

import logging
from typing import Protocol, final

from tool0.protocol.bus import Bus, Overran
from tool0.protocol.state import Snapshot
from tool0.simulation.clock import Lag, SpeedMeter
from tool0.simulation.core import Core

logger = logging.getLogger(__name__)


class Pace(Protocol):
    """The state of the loop that the publisher reads."""

    is_paused: bool
    speed: float | None
    """Requested ratio of simulated time to wall time; None if time passes only on
    request."""
    fault: Exception | None
    """Error that has stopped the simulation; None if there is no error."""
    steps: int
    """Number of ticks since the start."""

    @property
    def is_realtime(self) -> bool:
        """Whether simulated time is synchronized with the wall clock."""

    @property
    def overruns(self) -> int:
        """Number of late ticks since the start."""


@final
class Publisher:
    """Creates snapshots.

    Only the thread that executes the tick may use ``Publisher``.
    """

    def __init__(self, core: Core, bus: Bus) -> None:
        self._core, self._bus = core, bus
        self._meter = SpeedMeter()
        self._lag = Lag()
        self.max_drift = 0.0
        """Largest deviation of an uncommanded joint from its initial position [rad |
        m]."""

    def restart_meter(self, overruns: int) -> None:
        """Restart the speed measurement; ``overruns`` is the number of late ticks."""
        self._meter.restart(self._core.time, overruns)

    def publish(self, pace: Pace, *, with_arms: bool = False) -> None:
        """Publish a snapshot, which contains the arms if ``with_arms`` is True.

        The arms are also included if subscribers need them.
        """
        core, bus, meter = self._core, self._bus, self._meter
        self.max_drift = core.drift(self.max_drift)
        time, fault = core.time, pace.fault
        if meter.measure(time, pace.overruns):
            self._announce_lag(pace)
        hardware, manager, world = core.hardware, core.manager, core.engine.world
        _, position, velocity, effort = core.state
        has_forces = bus.are_forces_due(time)
        has_arms = with_arms or (bus.wants_arms and has_forces)
        bus.publish(
            Snapshot(  # positional, since keywords are ten times slower
                time,
                core.ticks,
                hardware.joint_names,
                tuple(position),
                tuple(velocity),
                tuple(effort),
                manager.list(),
                pace.is_paused,
                hardware.is_stopped,
                meter.factor,
                pace.overruns,
                meter.late_ticks,
                None if fault is None else str(fault),
                pace.speed,
                manager.setpoints(),
                {},  # no received setpoints, since this process computes them
                core.scene.objects,
                world.object_states(),
                core.stall_monitor.stalls,
                core.grip_contacts.gripping,
                core.arms.boxes,
                tuple(core.newest_command()) if bus.wants_commands else (),
                core.arm_samples() if has_arms else {},
                world.contacts() if bus.wants_contacts and has_forces else (),
                pace.steps,
            )
        )

    def _announce_lag(self, pace: Pace) -> None:
        """Announce that the simulation is falling behind real time or has caught up."""
        if not pace.is_realtime or pace.is_paused:
            return
        factor, late_ticks = self._meter.factor, self._meter.late_ticks
        speed = pace.speed or 1.0
        if not self._lag.changes(factor / speed):
            return
        is_behind = self._lag.is_behind
        self._bus.announce(Overran(late_ticks if is_behind else 0, self._core.time))
        logger.warning(
            "the simulation %s: %.2f x real time of %g x, %d late ticks a second",
            "falls behind" if is_behind else "keeps up again",
            factor,
            speed,
            late_ticks,
        )
