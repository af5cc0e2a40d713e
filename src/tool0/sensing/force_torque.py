"""A force-torque sensor that the tick samples, and all such sensors of a robot."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import final

from tool0.description.model import FLANGE, RobotModel
from tool0.description.payload import Payload
from tool0.description.robot import RobotDescription
from tool0.description.scene_state import Contact
from tool0.errors import ControlError
from tool0.hardware.engine import Engine, JointState
from tool0.protocol.sensors import DEFAULT_CUTOFF, WrenchReading
from tool0.sensing.low_pass import LowPass
from tool0.sensing.tool_meter import ToolMeter

Contacts = Callable[[frozenset[str]], tuple[Contact, ...]]
"""Function that returns at least the external forces on the given links."""

RATES = (50.0, 1000.0)
"""Minimum and maximum sampling rate [Hz]."""
DEFAULT_RATE = 125.0
"""Default sampling rate [Hz], which is also the sampling rate of a UR. If the rate does
not divide the control rate, the next lower divisor is used."""
READINGS_KEPT = 4096
"""Number of samples that are kept for slow readers: four seconds at 1 kHz."""


@final
class ForceTorqueSensor:
    """A sensor that is sampled every few ticks; any thread may read and tare it."""

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
        """Measure the wrench at ``link`` every ``ticks`` ticks.

        The tool consists of ``link`` and all links that it carries. ``rate`` is the
        sampling rate [Hz], and ``cutoff`` is the cutoff frequency of the filter [Hz].
        """
        self.link = link
        self.rate = rate
        self._meter = ToolMeter(model, link, engine)
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
        """Number of ticks until the next sample, which is at least one."""
        return self._left

    def tick(
        self,
        before: JointState,
        after: JointState,
        contacts: Contacts,
        ticks: int = 1,
    ) -> None:
        """Sample the last of ``ticks`` ticks if a sample is due.

        The last tick was from state ``before`` to state ``after``. ``ticks`` must not
        exceed ``ticks_left``.
        """
        self._left -= ticks
        if self._left == 0:
            self._left = self._ticks
            self._sample(before, after, contacts)

    def skip(self, ticks: int) -> None:
        """Count ``ticks`` without a sample, at most ``ticks_left`` - 1."""
        self._left -= ticks

    def subtract(self, payloads: Mapping[str, Payload]) -> None:
        """Subtract each flange's payload from the readings, as a UR does.

        Call ``subtract`` in the thread of the tick.
        """
        self._meter.subtract(payloads)

    def restart(
        self, before: JointState, after: JointState, contacts: Contacts
    ) -> None:
        """Take a sample with a new filter at the start and after a reset."""
        self._left = self._ticks
        self._filter = LowPass(self._cutoff, self.rate)
        self._sample(before, after, contacts)

    def zero(self) -> None:
        """Tare the sensor: subtract the current filtered wrench from later samples."""
        with self._changed:
            self._offset = self._last[2]
            self._readings[-1] = self._reading()

    def latest(self) -> WrenchReading:
        """Return the newest sample."""
        with self._changed:
            return self._readings[-1]

    def samples(self, since: int, timeout: float | None) -> tuple[WrenchReading, ...]:
        """Wait at most ``timeout`` [wall s] for samples after ``since``; return them.

        The first sample contains the number of samples that were dropped before it.
        """
        with self._changed:
            if since > self._number:  # ``since`` is from before a restart
                since = -1
            self._changed.wait_for(lambda: self._number > since, timeout)
            count = min(self._number - since, len(self._readings))
            found = [self._readings[i] for i in range(-count, 0)]
        if dropped := found and found[0].number - since - 1:
            found[0] = replace(found[0], dropped=dropped)
        return tuple(found)

    def _sample(
        self, before: JointState, after: JointState, contacts: Contacts
    ) -> None:
        meter = self._meter
        raw = meter.wrench(before, after, contacts(meter.links))
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
    """Starts, stops and finds sensors. Any thread may use this object.

    A sensor is not sampled until it is started. The first reading starts the sensor.
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
        """Create the sensors without starting them.

        ``start`` must make the tick sample a sensor once per ``control_period`` [s];
        ``stop`` must end the sampling.
        """
        self._description = description
        self._engine = engine
        self._control_period = control_period
        self._start_sampling = start
        self._stop_sampling = stop
        self._lock = threading.Lock()
        self._sensors: dict[str, ForceTorqueSensor] = {}

    def link(self, name: str | None) -> str:
        """Return the link at which to measure; see ``measured_link``."""
        return measured_link(self._description, name)

    def rate(self, link: str) -> float:
        """Return the sampling rate in simulated time [Hz]; 0 before the start."""
        sensor = self._sensors.get(link)
        return 0.0 if sensor is None else sensor.rate

    def sensor(self, link: str) -> ForceTorqueSensor:
        """Return the sensor at ``link``; if necessary, start it with the defaults."""
        with self._lock:
            return self._sensors.get(link) or self._start(link, None, DEFAULT_CUTOFF)

    def start(self, link: str, rate: float | None, cutoff: float) -> float:
        """Start or restart sampling without a tare; return the sampling rate [Hz].

        If ``rate`` is None, the rate is 125 Hz, or the next lower divisor of the
        control rate.

        Raises:
            ControlError: If the rate or the cutoff is out of range.
        """
        with self._lock:
            return self._start(link, rate, cutoff).rate

    def stop(self, link: str) -> None:
        """Stop sampling and discard the tare; further calls have no effect."""
        with self._lock:
            sensor = self._sensors.pop(link, None)
            if sensor is not None:
                self._stop_sampling(sensor)

    def _start(self, link: str, rate: float | None, cutoff: float) -> ForceTorqueSensor:
        ticks = ticks_between_samples(rate, self._control_period)
        sensor = ForceTorqueSensor(
            self._description.model,
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


def measured_link(description: RobotDescription, name: str | None) -> str:
    """Return the link at which to measure, given the name of a link or sensor.

    By default, the result is the robot's only link ``tool0``.

    Raises:
        ModelError: If there is no link or sensor with this name.
        ControlError: If no name is specified, and the robot does not have exactly one
            link ``tool0``.
    """
    model = description.model
    if name is not None:
        return model.link(model.wrench_sensors.get(name, name)).name
    names = model.flanges
    if (tool0 := description.prefix + FLANGE) in names:
        names = (tool0,)
    if len(names) != 1:
        raise ControlError(
            "'force_torque' needs exactly one link 'tool0', this robot has: "
            f"{', '.join(names) or 'none'}; pass a link to 'force_torque_of'"
        )
    return names[0]


def ticks_between_samples(rate: float | None, period: float) -> int:
    """Return the number of control periods of ``period`` [s] between two samples.

    Args:
        rate: Sampling rate [Hz]. None stands for 125 Hz, or for the next lower divisor
            of the control rate.
        period: Control period [s].

    Raises:
        ControlError: If the rate is out of range, or does not divide the control rate.
    """
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
