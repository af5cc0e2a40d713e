"""Force-torque sensors of all copies of a batch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import Arguments, Indices, Which
from tool0.description.robot import RobotDescription
from tool0.protocol.sensors import DEFAULT_CUTOFF
from tool0.sensing.force_torque import measured_link, ticks_between_samples
from tool0.sensing.low_pass import SecondOrder
from tool0.sensing.tool_meter import ToolMeter

if TYPE_CHECKING:
    from tool0.batch.backend import BatchBackend
    from tool0.kernel.memory import Addresses
    from tool0.simulation.core import Core

Array = NDArray[np.float64]


class SensorKind(NamedTuple):
    """What distinguishes a sensor from another one."""

    link: str
    ticks: int
    """Control periods between two samples."""
    rate: float
    """Samples per simulated second [Hz]."""
    cutoff: float
    """Of the low-pass filter [Hz]."""


class SavedSensor(NamedTuple):
    """A sensor of one copy at one instant, without its tare."""

    left: int
    raw: Array
    passed: Array
    memory: Array


@final
class CopySensor:
    """One sensor in all n copies: ``ForceTorqueSensor`` for each of them."""

    def __init__(self, kind: SensorKind, cores: Sequence[Core]) -> None:
        """Sample nothing yet."""
        n = len(cores)
        self.kind = kind
        self._cores = cores
        self._filter = SecondOrder.of(kind.cutoff, kind.rate)
        self._meter = ToolMeter(cores[0].model, kind.link, cores[0].engine)
        self._meter.subtract(cores[0].hardware.payloads)
        self.left = np.zeros(n, dtype=np.int64)
        """Ticks until the next sample of each copy, at least one."""
        self._raw, self._passed, self._offset = np.zeros((3, n, 6))
        self._memory = np.zeros((n, 6, 2))

    @property
    def raw(self) -> Array:
        """The newest samples without filter and with tare, shape (n, 6)."""
        return self._raw - self._offset

    @property
    def passed(self) -> Array:
        """The newest samples behind the filter, with tare, shape (n, 6)."""
        return self._passed - self._offset

    def zero(self, rows: Indices) -> None:
        """Tare these copies: subtract the filtered sample from now on."""
        self._offset[rows] = self._passed[rows]

    def restart(self, rows: Indices) -> None:
        """Sample these copies, whose cores are up to date, with a new filter."""
        raw = self._measured(rows, None)
        b0, _, a2 = self._filter
        self._memory[rows] = np.stack([(1.0 - b0) * raw, (b0 - a2) * raw], axis=-1)
        self._take(rows, raw)

    def tick(self, ticks: NDArray[np.int64], steps: Addresses) -> None:
        """Sample the copies that are due after so many ticks of each, shape (n,).

        ``steps`` is where the kernel has their last step, as ``ToolMeter.wrenches``
        takes it, shape (n, 3); 0 where it is that of the core.
        """
        self.left -= ticks
        rows = (self.left == 0).nonzero()[0]
        if rows.size:
            self._take(rows, self._measured(rows, steps))

    def saved(self, i: int) -> SavedSensor:
        """Return the state of one copy."""
        return SavedSensor(
            int(self.left[i]),
            *(each[i].copy() for each in (self._raw, self._passed, self._memory)),
        )

    def resume(self, i: int, saved: SavedSensor) -> None:
        """Continue with the state of one copy."""
        self.left[i], self._raw[i], self._passed[i], self._memory[i] = saved

    def _take(self, rows: Indices, raw: Array) -> None:
        b0, a1, a2 = self._filter
        memory = self._memory[rows]
        passed = b0 * raw + memory[..., 0]
        memory[..., 0] = 2.0 * b0 * raw - a1 * passed + memory[..., 1]
        memory[..., 1] = b0 * raw - a2 * passed
        self._raw[rows], self._passed[rows], self._memory[rows] = raw, passed, memory
        self.left[rows] = self.kind.ticks

    def _measured(self, rows: Indices, steps: Addresses | None) -> Array:
        """Return the wrenches in the last steps of these copies, (len(rows), 6)."""
        found = np.empty((len(rows), 6))
        is_native = np.zeros(len(rows), dtype=np.bool_)
        if steps is not None:
            is_native = steps[rows, 0] != 0
        if is_native.any() and steps is not None:
            native = is_native.nonzero()[0]
            wrenches = self._meter.wrenches(steps[rows[native]])
            found[native] = wrenches.wrench
            for number, k in enumerate(native.tolist()):
                world = self._cores[rows[k]].engine.world
                if world.is_touched(self._meter.links):
                    forces = wrenches.forces(number)
                    found[k] = self._meter.with_contacts(forces, world.contacts())
        for k in (~is_native).nonzero()[0].tolist():
            core = self._cores[rows[k]]
            before, after = core.last_step
            contacts = core.engine.world.contacts()
            found[k] = self._meter.wrench(before, after, contacts)
        return found


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
        alone: Callable[[], AbstractContextManager[None]],
        changing: Callable[[], AbstractContextManager[None]],
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
        with self._changing():
            sensor = CopySensor(kind, self._cores)
            self._stop()
            self._copies.start_sensor(sensor)
            self._sensor = sensor
        return kind.rate

    def stop(self) -> None:
        """Stop sampling and forget the tare; stopping twice is allowed."""
        with self._changing():
            self._stop()

    def zero(self, which: Which | None = None) -> None:
        """Tare the sensor of copies until it is started again; resets keep the tare."""
        rows = Arguments(len(self._cores), "force_torque.zero").which(which)
        with self._changing():
            self._running().zero(rows)

    def read(self) -> Array:
        """Return force and torque of the newest samples, filtered, shape (n, 6).

        The first call starts the sensor with its defaults.

        Raises:
            ControlError: If this is a GPU.
        """
        with self._alone():
            found = self._running().passed
        found.flags.writeable = False
        return found

    def read_raw(self) -> Array:
        """Return the same without the filter, shape (n, 6)."""
        with self._alone():
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
