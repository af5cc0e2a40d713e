"""The force-torque sensors of a robot: one for each link that was asked for."""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Callable, Sequence
from typing import final

from tool0.description.catalogue import RobotDescription
from tool0.description.model import FLANGE
from tool0.description.transform import Vector3
from tool0.errors import ControlError
from tool0.hardware.low_pass import LowPass
from tool0.sensing.force_torque_sensor import ForceTorqueSensor

RATES = (50.0, 1000.0)
"""Slowest and fastest sampling [Hz]."""
DEFAULT_RATE = 125.0
"""Sampling rate [Hz] where the control rate is a multiple of it: that of a UR."""
DEFAULT_CUTOFF = 15.0
"""Cut-off of the filter [Hz]: a compromise between a load's weight and vibrations of
the arm; not from a data sheet."""


@final
class ForceTorqueSensors:
    """Starts, stops and finds sensors.  Any thread may use it.

    A sensor costs nothing until it is started; the first reading starts it.
    """

    def __init__(
        self,
        description: RobotDescription,
        *,
        joint_names: Sequence[str],
        dt: float,
        gravity: Vector3,
        control_period: float,
        start: Callable[[ForceTorqueSensor], None],
        stop: Callable[[ForceTorqueSensor], None],
    ) -> None:
        """Start none.

        Args:
            description: The robot.
            joint_names: The engine's joints, in its order.
            dt: The engine's step [s].
            gravity: In the axes of the robot's root [m/s²].
            control_period: Time between two ticks [s].
            start: Lets the tick sample a sensor.
            stop: Ends that.
        """
        self._model = description.model
        self._tool0 = description.prefix + FLANGE
        self._joint_names = tuple(joint_names)
        self._dt = dt
        self._gravity = gravity
        self._control_period = control_period
        self._start_sampling = start
        self._stop_sampling = stop
        self._lock = threading.Lock()
        self._sensors: dict[str, ForceTorqueSensor] = {}
        self._rates: dict[str, float] = {}

    def link(self, name: str | None) -> str:
        """Return the link to measure at: ``name``, or the robot's only ``tool0``.

        Raises:
            ModelError: If there is no such link.
            ControlError: If no name is given, and there is no ``tool0`` or several.
        """
        if name is not None:
            return self._model.link(name).name
        names = self._model.flanges
        if self._tool0 in names:
            names = (self._tool0,)
        if len(names) != 1:
            raise ControlError(
                "'force_torque' needs exactly one link 'tool0', this robot has: "
                f"{', '.join(names) or 'none'}; name a link to 'force_torque_of'"
            )
        return names[0]

    def rate(self, link: str) -> float:
        """Return the samples per simulated second [Hz]; 0 while it is not started."""
        return self._rates.get(link, 0.0)

    def sensor(self, link: str) -> ForceTorqueSensor:
        """Return the sensor at ``link``, started with the defaults if need be."""
        with self._lock:
            return self._sensors.get(link) or self._start(link, None, DEFAULT_CUTOFF)

    def start(self, link: str, rate: float | None, cutoff: float) -> float:
        """Start to sample without tare, again if it is running; return the rate [Hz].

        Args:
            link: The link that carries the tool.
            rate: Samples per simulated second [Hz], 50 … 1000 and a divisor of the
                control rate; None for 125 or the next divisor below.
            cutoff: Of the low-pass filter [Hz] (``hardware/low_pass.py``).

        Raises:
            ControlError: If either is out of range.
        """
        with self._lock:
            self._start(link, rate, cutoff)
            return self._rates[link]

    def stop(self, link: str) -> None:
        """Stop to sample and forget the tare; stopping twice is allowed."""
        with self._lock:
            sensor = self._sensors.pop(link, None)
            self._rates.pop(link, None)
            if sensor is not None:
                self._stop_sampling(sensor)

    def _start(self, link: str, rate: float | None, cutoff: float) -> ForceTorqueSensor:
        ticks = _ticks_between_samples(rate, self._control_period)
        exact = 1.0 / (ticks * self._control_period)
        sensor = ForceTorqueSensor(
            self._model,
            link,
            self._joint_names,
            dt=self._dt,
            gravity=self._gravity,
            ticks=ticks,
            low_pass=functools.partial(LowPass, cutoff, exact),
        )
        if link in self._sensors:
            self._stop_sampling(self._sensors[link])
        self._start_sampling(sensor)
        self._sensors[link], self._rates[link] = sensor, exact
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
        f"rate {rate:g} Hz is no divisor of the control rate, {control_rate:g} Hz; "
        f"the nearest one is {near:g} Hz"
    )
