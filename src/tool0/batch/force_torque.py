"""Programming interface of the force-torque sensors of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, final

from tool0.batch.arguments import Arguments, Which
from tool0.batch.copy_sensor import Array, CopySensor, SensorKind
from tool0.batch.state import State, frozen
from tool0.description.robot import RobotDescription
from tool0.protocol.sensors import DEFAULT_CUTOFF
from tool0.sensing.force_torque import measured_link, ticks_between_samples

if TYPE_CHECKING:
    from tool0.batch.backend import BatchBackend
    from tool0.simulation.core import Core


@final
class BatchForceTorque:
    """Sensor of the wrench that the tool exerts on its carrying link in each copy.

    As with ``robot.force_torque``, the measured force [N] and torque [N·m] include the
    effects of the tool's weight, inertia and contacts.  Force and torque are given at
    the origin and in the axes of the link.  The sensor uses no computing time until the
    first reading starts it.  The samples of each copy are timed by its clock: A sample
    is taken when the sensor starts, when the copy is reset, and every ``1 / rate``
    seconds after these events.
    """

    def __init__(
        self,
        link: str | None,
        description: RobotDescription,
        cores: Sequence[Core],
        copies: BatchBackend,
        state: State,
    ) -> None:
        """Create the sensor at a link, given the name of the link or of a sensor.

        See ``measured_link``.

        The sensor uses the guards of ``state``.
        """
        self._link = measured_link(description, link)
        self._cores, self._copies = cores, copies
        self._alone, self._changing = state.alone, state.changing
        self._sensor: CopySensor | None = None

    @property
    def link(self) -> str:
        """The link that carries the tool."""
        return self._link

    @property
    def rate(self) -> float:
        """Samples per simulated second [Hz]; 0 while the sensor is stopped."""
        return 0.0 if self._sensor is None else self._sensor.kind.rate

    def start(self, rate: float | None = None, cutoff: float = DEFAULT_CUTOFF) -> float:
        """Start sampling without a tare, and return the rate [Hz].

        A running sensor is restarted.

        Args:
            rate: Samples per simulated second [Hz], 50 … 1000 and a divisor of the
                control rate.  The default is 125 Hz or the next lower divisor.
            cutoff: Cutoff frequency of the low-pass filter [Hz], below half the rate.

        Raises:
            ControlError: If an argument is out of range, or the batch runs on a GPU.
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
        """Stop sampling and discard the tare; further calls have no effect."""
        with self._changing:
            self._stop()

    def zero(self, which: Which | None = None) -> None:
        """Tare the sensor of copies; the tare survives resets, but not a restart."""
        rows = Arguments(len(self._cores), "force_torque.zero").which(which)
        with self._changing:
            self._running().zero(rows)

    def read(self) -> Array:
        """Return the newest filtered force [N] and torque [N·m], shape (n, 6).

        The first call starts the sensor with its defaults.

        Raises:
            ControlError: If the batch runs on a GPU.
        """
        with self._alone:
            return frozen(self._running().passed)

    def read_raw(self) -> Array:
        """Return the newest unfiltered force [N] and torque [N·m], shape (n, 6)."""
        with self._alone:
            return frozen(self._running().raw)

    def _running(self) -> CopySensor:
        if self._sensor is None:
            self.start()
        assert self._sensor is not None
        return self._sensor

    def _stop(self) -> None:
        if self._sensor is not None:
            self._copies.stop_sensor(self._sensor)
            self._sensor = None


@final
class BatchForceTorques:
    """Force-torque sensors of a batch; a sensor is made at the first request."""

    def __init__(
        self,
        description: RobotDescription,
        cores: Sequence[Core],
        copies: BatchBackend,
        state: State,
    ) -> None:
        """Make sensors for ``copies`` of the robot, with the guards of ``state``."""
        self._description = description
        self._cores, self._copies, self._state = cores, copies, state
        self._sensors: dict[str | None, BatchForceTorque] = {}
        """Sensors by link, and by each other name that was used to request a sensor."""

    def at(self, link: str | None) -> BatchForceTorque:
        """Return a sensor; see ``Batch.force_torque_of``."""
        if link not in self._sensors:
            sensor = BatchForceTorque(
                link, self._description, self._cores, self._copies, self._state
            )
            named = self._sensors.setdefault(sensor.link, sensor)
            self._sensors[link] = named
        return self._sensors[link]
