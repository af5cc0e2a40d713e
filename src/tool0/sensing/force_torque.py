"""The wrench at a wrist, as a person reads it."""

from __future__ import annotations

import functools
import math
import threading
import time
from collections.abc import Sequence
from typing import final

from tool0.description.catalogue import RobotDescription
from tool0.description.model import FLANGE, RobotModel
from tool0.description.transform import Vector3
from tool0.errors import ControlError
from tool0.hardware.low_pass import LowPass
from tool0.runtime import commands as ask
from tool0.runtime.loop import Loop
from tool0.sensing.force_torque_sensor import ForceTorqueSensor
from tool0.sensing.wrench import WrenchReading

RATES = (50.0, 1000.0)
"""Slowest and fastest sampling [Hz]."""
DEFAULT_RATE = 125.0
"""Of sampling [Hz], where the control rate is a multiple of it: the UR's own."""
DEFAULT_CUTOFF = 15.0
"""Of the filter [Hz]: a guess between the weight of a thing and the arm's trembling."""
_PATIENCE = 0.05  # [wall s] between looks at whether the loop still lives


@final
class ForceTorque:
    """What the tool exerts on the flange: its weight, its inertia, what presses on it.

    In the axes of the link at its origin, with the sign of the UR's own ``wrench`` and
    of Gazebo's sensor, ``child_to_parent``: a tool that hangs down pulls along +z.  It
    costs nothing until it is started; the first reading starts it.  Gazebo tells what
    presses only after it was asked once: there the very first sample lacks it.
    """

    def __init__(
        self,
        model: RobotModel,
        link: str,
        *,
        joint_names: Sequence[str],
        dt: float,
        gravity: Vector3,
        loop: Loop,
    ) -> None:
        """Look at ``link`` of ``model``.

        Args:
            model: The robot.
            link: What carries the tool; itself and all beyond it is the tool.
            joint_names: The engine's joints, in its order.
            dt: The engine's step [s].
            gravity: In the axes of the robot's root [m/s²].
            loop: Whose ticks sample.

        Raises:
            ModelError: If there is no such link.
        """
        self.link = model.link(link).name
        self._model = model
        self._joint_names = tuple(joint_names)
        self._dt = dt
        self._gravity = gravity
        self._loop = loop
        self._lock = threading.Lock()
        self._sensor: ForceTorqueSensor | None = None
        self._rate = 0.0

    @property
    def rate(self) -> float:
        """Samples per simulated second [Hz]; 0 while it is not started."""
        return self._rate

    def start(self, rate: float | None = None, cutoff: float = DEFAULT_CUTOFF) -> None:
        """Begin to sample, anew if it does already, from no zero but nature's.

        Args:
            rate: Samples per simulated second [Hz], 50 … 1000 and a whole part of the
                control rate; left out, 125 or what next below is such a part.
            cutoff: Of the low-pass filter [Hz] (``hardware/low_pass.py``).

        Raises:
            ControlError: If either is out of range.
        """
        with self._lock:
            self._start(rate, cutoff)

    def stop(self) -> None:
        """Sample no more, and forget the zero; stopping twice is allowed."""
        with self._lock:
            if self._sensor is not None:
                self._loop.call(ask.StopSensor(self._sensor))
            self._sensor, self._rate = None, 0.0

    def read(self) -> WrenchReading:
        """Return the newest sample; start first if need be, which makes one."""
        return self._started().latest()

    def zero(self) -> None:
        """Call what is felt now zero, until it is started anew: UR's ``zero_ftsensor``.

        A reset of the simulation keeps it, as a sensor would.
        """
        self._started().zero()

    def samples(
        self, since: int = -1, timeout: float | None = 0.0
    ) -> tuple[WrenchReading, ...]:
        """Return all samples after ``since``, oldest first; the last 4096 are kept.

        Args:
            since: The ``number`` of the last one that is known already; one from before
                the sensor was started anew counts as none.
            timeout: How long to wait for the first [wall s]; None for ever.

        Raises:
            ControlError: If the simulation is closed meanwhile.
            EngineError: If the physics failed: none would ever come.
        """
        end = time.monotonic() + (math.inf if timeout is None else timeout)
        while True:
            left = max(0.0, end - time.monotonic())
            found = self._started().samples(since, min(left, _PATIENCE))
            if found or left == 0.0:
                return found
            self._loop.check()
            if self._loop.is_closed:
                raise ControlError("the simulation was closed")

    def _started(self) -> ForceTorqueSensor:
        with self._lock:
            return self._sensor or self._start(None, DEFAULT_CUTOFF)

    def _start(self, rate: float | None, cutoff: float) -> ForceTorqueSensor:
        ticks = _ticks(rate, self._loop.control_period)
        exact = 1.0 / (ticks * self._loop.control_period)
        sensor = ForceTorqueSensor(
            self._model,
            self.link,
            self._joint_names,
            dt=self._dt,
            gravity=self._gravity,
            ticks=ticks,
            low_pass=functools.partial(LowPass, cutoff, exact),
        )
        if self._sensor is not None:
            self._loop.call(ask.StopSensor(self._sensor))
        self._loop.call(ask.StartSensor(sensor))
        self._sensor, self._rate = sensor, exact
        return sensor


@final
class ForceTorques:
    """One for each link that was asked for.  Any thread may ask."""

    def __init__(
        self,
        description: RobotDescription,
        *,
        joint_names: Sequence[str],
        dt: float,
        gravity: Vector3,
        loop: Loop,
    ) -> None:
        """Start none; see ``ForceTorque`` for the arguments."""
        self._model = description.model
        self._tool0 = description.prefix + FLANGE
        self._joint_names = joint_names
        self._dt = dt
        self._gravity = gravity
        self._loop = loop
        self._lock = threading.Lock()
        self._known: dict[str, ForceTorque] = {}

    def at(self, link: str) -> ForceTorque:
        """Return the one at ``link``, or raise ModelError."""
        with self._lock:
            if link not in self._known:
                self._known[link] = ForceTorque(
                    self._model,
                    link,
                    joint_names=self._joint_names,
                    dt=self._dt,
                    gravity=self._gravity,
                    loop=self._loop,
                )
            return self._known[link]

    def at_tool0(self) -> ForceTorque:
        """Return the one at ``tool0``.

        That is the link of this name with the robot's prefix, or else the only one
        whose name ends so.

        Raises:
            ControlError: If there is none, or more than one.
        """
        names = self._model.flanges
        if self._tool0 in names:
            names = (self._tool0,)
        if len(names) != 1:
            raise ControlError(
                "'force_torque' needs exactly one link 'tool0', this robot has: "
                f"{', '.join(names) or 'none'}; name a link to 'force_torque_of'"
            )
        return self.at(names[0])


def _ticks(rate: float | None, period: float) -> int:
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
        f"rate {rate:g} Hz is no whole part of the control rate, {control_rate:g} Hz; "
        f"the nearest that is is {near:g} Hz"
    )
