"""Force-torque sensors of the copies of a batch, as a program uses them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, final

from tool0.batch.arguments import Arguments, Which
from tool0.batch.copy_sensor import Array, CopySensor, SensorKind
from tool0.batch.one_thread import OneThread
from tool0.description.robot import RobotDescription
from tool0.protocol.sensors import DEFAULT_CUTOFF
from tool0.sensing.force_torque import measured_link, ticks_between_samples

if TYPE_CHECKING:
    from tool0.batch.backend import BatchBackend
    from tool0.simulation.core import Core


@final
class BatchForceTorque:
    """Measures the wrench that a tool exerts on the link that carries it, in each copy.

    It measures as ``robot.force_torque``: force [N] and torque [N·m] include the tool's
    weight, inertia and contacts, in the axes of the link, at its origin.  It costs
    nothing until it is started; the first reading starts it.  Each copy is sampled in
    its own time: at the start, at its reset, and every ``1 / rate`` after that.
    """

    def __init__(
        self,
        link: str | None,
        description: RobotDescription,
        cores: Sequence[Core],
        copies: BatchBackend,
        *,
        alone: OneThread,
        changing: OneThread,
    ) -> None:
        """Measure at a link, by its name or that of a sensor; see ``measured_link``.

        ``alone`` and ``changing`` are those of ``Batch``.
        """
        self._link = measured_link(description, link)
        self._cores, self._copies = cores, copies
        self._alone, self._changing = alone, changing
        self._sensor: CopySensor | None = None

    @property
    def link(self) -> str:
        """The link that carries the tool."""
        return self._link

    @property
    def rate(self) -> float:
        """Samples per simulated second [Hz]; 0 while it is not started."""
        return 0.0 if self._sensor is None else self._sensor.kind.rate

    def start(self, rate: float | None = None, cutoff: float = DEFAULT_CUTOFF) -> float:
        """Start sampling without a tare and return the rate [Hz].

        A sensor that is running starts again.

        Args:
            rate: Samples per simulated second [Hz], 50 … 1000 and a divisor of the
                control rate.  If you leave it out, 125 or the next divisor below.
            cutoff: Cut-off of the low-pass filter [Hz], below half the rate.

        Raises:
            ControlError: If either is out of range, or this is a GPU.
        """
        period = self._cores[0].control_period
        ticks = ticks_between_samples(rate, period)
        kind = SensorKind(self._link, ticks, 1.0 / (ticks * period), cutoff)
        with self._changing:
            sensor = CopySensor(kind, self._cores)
            self._stop()
            self._copies.start_sensor(sensor)
            self._sensor = sensor
        return kind.rate

    def stop(self) -> None:
        """Stop sampling and forget the tare; stopping twice is allowed."""
        with self._changing:
            self._stop()

    def zero(self, which: Which | None = None) -> None:
        """Tare the sensor of copies until it is started again; resets keep the tare."""
        rows = Arguments(len(self._cores), "force_torque.zero").which(which)
        with self._changing:
            self._running().zero(rows)

    def read(self) -> Array:
        """Return force and torque of the newest samples, filtered, shape (n, 6).

        The first call starts the sensor with its defaults.

        Raises:
            ControlError: If this is a GPU.
        """
        with self._alone:
            found = self._running().passed
        found.flags.writeable = False
        return found

    def read_raw(self) -> Array:
        """Return the same without the filter, shape (n, 6)."""
        with self._alone:
            found = self._running().raw
        found.flags.writeable = False
        return found

    def _running(self) -> CopySensor:
        if self._sensor is None:
            self.start()
        assert self._sensor is not None
        return self._sensor

    def _stop(self) -> None:
        if self._sensor is not None:
            self._copies.stop_sensor(self._sensor)
            self._sensor = None
