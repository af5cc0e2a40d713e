"""Force-torque sensors: one sensor, sampled by the tick, and all of a robot."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import final

from tool0.description.model import FLANGE, RobotModel
from tool0.description.payload import Payload
from tool0.description.payload_bodies import payload_inertia
from tool0.description.robot import RobotDescription
from tool0.description.scene_state import Contact
from tool0.errors import ControlError
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.tool_dynamics import ToolDynamics
from tool0.protocol.sensors import DEFAULT_CUTOFF, WrenchReading

Contacts = Callable[[], tuple[Contact, ...]]

RATES = (50.0, 1000.0)
"""Slowest and fastest sampling [Hz]."""
DEFAULT_RATE = 125.0
"""Default sampling rate [Hz] if it divides the control rate: that of a UR."""
READINGS_KEPT = 4096
"""Number of samples kept for slow readers: four seconds at 1 kHz."""


@final
class LowPass:
    """A second-order Butterworth low-pass filter for several values at once.

    H(s) = 1 / (s² + √2 s + 1), s in units of the cutoff, discretised by the bilinear
    transform with frequency prewarping at the cutoff:

        y = b0 x + 2 b0 x' + b0 x" - a1 y' - a2 y",  K = tan(π cutoff / rate),
        b0 = K² / d,  a1 = 2 (K² - 1) / d,  a2 = (1 - √2 K + K²) / d,  d = 1 + √2 K + K²

    The gain is 0.71 at the cutoff and 0.01 at ten times the cutoff.  A ramp is delayed
    by 0.225 / cutoff: 15 ms at 15 Hz.  The initial state is that of a constant input
    equal to the first sample.
    """

    def __init__(self, cutoff: float, rate: float) -> None:
        """Initialise the filter.

        Args:
            cutoff: [Hz], below half the rate.
            rate: Samples per second [Hz].

        Raises:
            ControlError: If the cutoff is out of range.
        """
        if not 0.0 < cutoff < rate / 2.0:
            raise ControlError(
                f"the cutoff must be above 0 Hz and below half the rate, "
                f"{rate / 2.0:g} Hz; got {cutoff:g} Hz"
            )
        k = math.tan(math.pi * cutoff / rate)
        d = 1.0 + math.sqrt(2.0) * k + k * k
        self._b0 = k * k / d
        self._a1 = 2.0 * (k * k - 1.0) / d
        self._a2 = (1.0 - math.sqrt(2.0) * k + k * k) / d
        self._memory: list[tuple[float, float]] = []

    def __call__(self, values: Sequence[float]) -> list[float]:
        """Return the filtered value of the next sample."""
        b0, a1, a2 = self._b0, self._a1, self._a2
        if not self._memory:
            self._memory = [((1.0 - b0) * x, (b0 - a2) * x) for x in values]
        passed, memory = [], []
        for x, (first, second) in zip(values, self._memory, strict=True):
            y = b0 * x + first
            passed.append(y)
            memory.append((2.0 * b0 * x - a1 * y + second, b0 * x - a2 * y))
        self._memory = memory
        return passed


@final
class ForceTorqueSensor:
    """A sensor sampled every few ticks; any thread may read and tare it."""

    def __init__(
        self,
        model: RobotModel,
        link: str,
        engine: Engine,
        *,
        ticks: int,
        rate: float,
        cutoff: float,
    ) -> None:
        """Measure at ``link`` every few ``ticks``; the tool is ``link`` and beyond.

        ``rate`` is the sampling rate [Hz], ``cutoff`` that of the filter [Hz].
        """
        self.link = link
        self.rate = rate
        self._dynamics = ToolDynamics(model, link, engine.world.gravity)
        names = engine.joint_names
        self._to_model = [names.index(joint.name) for joint in model.movable_joints]
        self._dt = engine.dt
        self._ticks = ticks
        self._left = ticks
        self._cutoff = cutoff
        self._filter = LowPass(cutoff, rate)
        self._changed = threading.Condition()
        self._offset = [0.0] * 6
        self._last = (0.0, [0.0] * 6, [0.0] * 6)  # time, raw and filtered, without tare
        self._number = -1
        self._readings: deque[WrenchReading] = deque(maxlen=READINGS_KEPT)

    @property
    def ticks_left(self) -> int:
        """Ticks until the next sample, at least one."""
        return self._left

    def tick(
        self,
        before: JointState,
        after: JointState,
        contacts: Contacts,
        ticks: int = 1,
    ) -> None:
        """Sample the last step of ``ticks``, if a sample is due.

        It is the one from ``before`` to ``after``; ``ticks`` are no more than are left.
        """
        self._left -= ticks
        if self._left == 0:
            self._left = self._ticks
            self._sample(before, after, contacts())

    def skip(self, ticks: int) -> None:
        """Note ``ticks`` without a sample: fewer than are left."""
        self._left -= ticks

    def subtract(self, payloads: Mapping[str, Payload]) -> None:
        """Subtract payloads, by flange, as a UR does; in the thread of the tick."""
        inertias = {link: payload_inertia(item) for link, item in payloads.items()}
        self._dynamics.subtract(inertias)

    def restart(
        self, before: JointState, after: JointState, contacts: Contacts
    ) -> None:
        """Sample now with a new filter: at the start, and after a reset."""
        self._left = self._ticks
        self._filter = LowPass(self._cutoff, self.rate)
        self._sample(before, after, contacts())

    def zero(self) -> None:
        """Tare: subtract the current filtered measurement from now on."""
        with self._changed:
            self._offset = self._last[2]
            self._readings[-1] = self._reading()

    def latest(self) -> WrenchReading:
        """Return the newest sample."""
        with self._changed:
            return self._readings[-1]

    def samples(self, since: int, timeout: float | None) -> tuple[WrenchReading, ...]:
        """Return samples after number ``since``; wait for the first [wall s].

        The first one says how many were dropped before it.
        """
        with self._changed:
            if since > self._number:  # from before the sensor was restarted
                since = -1
            self._changed.wait_for(lambda: self._number > since, timeout)
            count = min(self._number - since, len(self._readings))
            found = [self._readings[i] for i in range(-count, 0)]
        if dropped := found and found[0].number - since - 1:
            found[0] = replace(found[0], dropped=dropped)
        return tuple(found)

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


@final
class ForceTorqueSensors:
    """Starts, stops and finds sensors.  Any thread may use it.

    A sensor costs nothing until it is started; the first reading starts it.
    """

    def __init__(
        self,
        description: RobotDescription,
        engine: Engine,
        *,
        control_period: float,
        start: Callable[[ForceTorqueSensor], None],
        stop: Callable[[ForceTorqueSensor], None],
    ) -> None:
        """Create the sensors without starting any.

        ``start`` lets the tick, each ``control_period`` [s], sample a sensor; ``stop``
        ends that.
        """
        self._model = description.model
        self._tool0 = description.prefix + FLANGE
        self._engine = engine
        self._control_period = control_period
        self._start_sampling = start
        self._stop_sampling = stop
        self._lock = threading.Lock()
        self._sensors: dict[str, ForceTorqueSensor] = {}

    def link(self, name: str | None) -> str:
        """Return the link to measure at, by the name of link or sensor.

        Without a name, it is the robot's only ``tool0``.

        Raises:
            ModelError: If there is neither.
            ControlError: If no name is given, and there is no ``tool0`` or several.
        """
        if name is not None:
            return self._model.link(self._model.wrench_sensors.get(name, name)).name
        names = self._model.flanges
        if self._tool0 in names:
            names = (self._tool0,)
        if len(names) != 1:
            raise ControlError(
                "'force_torque' needs exactly one link 'tool0', this robot has: "
                f"{', '.join(names) or 'none'}; pass a link to 'force_torque_of'"
            )
        return names[0]

    def rate(self, link: str) -> float:
        """Return the sampling rate in simulated time [Hz]; 0 if it is not started."""
        sensor = self._sensors.get(link)
        return 0.0 if sensor is None else sensor.rate

    def sensor(self, link: str) -> ForceTorqueSensor:
        """Return the sensor at ``link``, started with the defaults if needed."""
        with self._lock:
            return self._sensors.get(link) or self._start(link, None, DEFAULT_CUTOFF)

    def start(self, link: str, rate: float | None, cutoff: float) -> float:
        """Start or restart sampling, without tare; return the rate [Hz].

        A ``rate`` of None [Hz] is 125, or the next divisor of the control rate below.

        Raises:
            ControlError: If either is out of range.
        """
        with self._lock:
            return self._start(link, rate, cutoff).rate

    def stop(self, link: str) -> None:
        """Stop sampling and forget the tare; stopping twice is allowed."""
        with self._lock:
            sensor = self._sensors.pop(link, None)
            if sensor is not None:
                self._stop_sampling(sensor)

    def _start(self, link: str, rate: float | None, cutoff: float) -> ForceTorqueSensor:
        ticks = _ticks_between_samples(rate, self._control_period)
        sensor = ForceTorqueSensor(
            self._model,
            link,
            self._engine,
            ticks=ticks,
            rate=1.0 / (ticks * self._control_period),
            cutoff=cutoff,
        )
        if link in self._sensors:
            self._stop_sampling(self._sensors[link])
        self._start_sampling(sensor)
        self._sensors[link] = sensor
        return sensor


def _ticks_between_samples(rate: float | None, period: float) -> int:
    """Return the control periods between samples, or raise ControlError."""
    if rate is None:
        return max(1, math.ceil(1.0 / (DEFAULT_RATE * period) - 1e-9))
    slowest, fastest = RATES
    if not slowest <= rate <= fastest:
        raise ControlError(f"rate {rate:g} Hz is outside [{slowest:g}, {fastest:g}] Hz")
    ticks = round(1.0 / (rate * period))
    if ticks and math.isclose(ticks * period * rate, 1.0, rel_tol=1e-6):
        return ticks
    control_rate = 1.0 / period
    most, least = math.floor(control_rate / slowest), math.ceil(control_rate / fastest)
    possible = (control_rate / n for n in range(max(1, least), most + 1))
    near = min(possible, key=lambda other: abs(other - rate), default=control_rate)
    raise ControlError(
        f"rate {rate:g} Hz does not divide the control rate, {control_rate:g} Hz; "
        f"the nearest rate that does is {near:g} Hz"
    )
