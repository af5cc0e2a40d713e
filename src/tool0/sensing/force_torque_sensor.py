"""A wrist's sensor of force and torque, as the thread of the tick has it."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

from tool0.description.model import RobotModel
from tool0.description.transform import Vector3
from tool0.hardware.engine import Contact
from tool0.hardware.joint_state import JointState
from tool0.hardware.low_pass import LowPass
from tool0.hardware.tool_dynamics import ToolDynamics

Contacts = Callable[[], tuple[Contact, ...]]

READINGS_KEPT = 4096
"""Samples that a reader may fall behind: four seconds at 1 kHz."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class WrenchReading:
    """What the tool exerts on the flange, averaged over one step of the physics.

    In the axes of ``frame``, at its origin, minus the reading at the last tare.
    """

    time: float
    """Simulated time at the end of the step [s]."""
    number: int
    """Number of the sample since the sensor was started; a reset does not change it."""
    frame: str
    """The link."""
    force: Vector3
    """Filtered [N]."""
    torque: Vector3
    """Filtered [N·m]."""
    raw_force: Vector3
    """[N]"""
    raw_torque: Vector3
    """[N·m]"""


@final
class ForceTorqueSensor:
    """Samples every so many ticks; any thread may read and zero it."""

    def __init__(
        self,
        model: RobotModel,
        link: str,
        joint_names: Sequence[str],
        *,
        dt: float,
        gravity: Vector3,
        ticks: int,
        low_pass: Callable[[], LowPass],
    ) -> None:
        """Measure nothing yet.

        Args:
            model: The robot.
            link: What beyond it pulls, and in whose frame that is told.
            joint_names: The engine's joints, in its order.
            dt: The engine's step [s].
            gravity: In the axes of the robot's root [m/s²].
            ticks: From one sample to the next.
            low_pass: Makes the filter, at the start and after a reset.
        """
        self.link = link
        self._dynamics = ToolDynamics(model, link, gravity)
        self._to_model = [joint_names.index(j.name) for j in model.movable_joints]
        self._dt = dt
        self._ticks = ticks
        self._left = ticks
        self._low_pass = low_pass
        self._filter = low_pass()
        self._changed = threading.Condition()
        self._offset = [0.0] * 6
        self._last = (0.0, [0.0] * 6, [0.0] * 6)  # time, raw and filtered, unzeroed
        self._number = -1
        self._readings: deque[WrenchReading] = deque(maxlen=READINGS_KEPT)

    def tick(self, before: JointState, after: JointState, contacts: Contacts) -> None:
        """Sample, if it is time to: the step that led from ``before`` to ``after``."""
        self._left -= 1
        if self._left == 0:
            self._left = self._ticks
            self._sample(before, after, contacts())

    def restart(
        self, before: JointState, after: JointState, contacts: Contacts
    ) -> None:
        """Sample at once and begin to filter anew: at the start, and after a reset."""
        self._left = self._ticks
        self._filter = self._low_pass()
        self._sample(before, after, contacts())

    def zero(self) -> None:
        """Call what is measured now, filtered, zero from now on."""
        with self._changed:
            self._offset = self._last[2]
            self._readings[-1] = self._reading()

    def latest(self) -> WrenchReading:
        """Return the newest sample."""
        with self._changed:
            return self._readings[-1]

    def samples(self, since: int, timeout: float | None) -> tuple[WrenchReading, ...]:
        """Return what came after number ``since``; wait for the first, [wall s]."""
        with self._changed:
            if since > self._number:  # of a sensor before this one
                since = -1
            self._changed.wait_for(lambda: self._number > since, timeout)
            count = min(self._number - since, len(self._readings))
            return tuple(self._readings[i] for i in range(-count, 0))

    def _sample(
        self, before: JointState, after: JointState, contacts: tuple[Contact, ...]
    ) -> None:
        order, dt = self._to_model, self._dt
        was, velocity = before.velocity, after.velocity
        raw = self._dynamics.wrench(
            [before.position[i] for i in order],
            [was[i] for i in order],
            [(velocity[i] - was[i]) / dt for i in order],
            contacts,
        )
        passed = self._filter(raw)
        with self._changed:
            self._last = (after.time, list(raw), passed)
            self._number += 1
            self._readings.append(self._reading())
            self._changed.notify_all()

    def _reading(self) -> WrenchReading:
        time, raw, passed = self._last
        fx, fy, fz, tx, ty, tz = map(float.__sub__, passed, self._offset)
        rx, ry, rz, sx, sy, sz = map(float.__sub__, raw, self._offset)
        return WrenchReading(
            time=time,
            number=self._number,
            frame=self.link,
            force=(fx, fy, fz),
            torque=(tx, ty, tz),
            raw_force=(rx, ry, rz),
            raw_torque=(sx, sy, sz),
        )
