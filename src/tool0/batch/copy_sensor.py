"""Samples, filter and tare of one force-torque sensor in all copies of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import Indices
from tool0.sensing.low_pass import SecondOrder
from tool0.sensing.tool_meter import ToolMeter

if TYPE_CHECKING:
    from tool0.kernel.memory import Addresses
    from tool0.simulation.core import Core

Array = NDArray[np.float64]


class SensorKind(NamedTuple):
    """Properties that identify a sensor."""

    link: str
    ticks: int
    """Control periods between two samples."""
    rate: float
    """Samples per simulated second [Hz]."""
    cutoff: float
    """Cutoff frequency of the low-pass filter [Hz]."""


class SavedSensor(NamedTuple):
    """State of the sensor in one copy at one instant, without the tare."""

    left: int
    raw: Array
    passed: Array
    memory: Array


@final
class CopySensor:
    """One sensor in all n copies, with separate samples, filter states and tares."""

    def __init__(self, kind: SensorKind, cores: Sequence[Core]) -> None:
        """Create the sensor without taking a sample."""
        n = len(cores)
        self.kind = kind
        self._cores = cores
        self._filter = SecondOrder.of(kind.cutoff, kind.rate)
        self._meter = ToolMeter(cores[0].model, kind.link, cores[0].engine)
        self._meter.subtract(cores[0].hardware.payloads)
        self.left = np.zeros(n, dtype=np.int64)
        """Ticks until the next sample of each copy, at least 1."""
        self._raw, self._passed, self._offset = np.zeros((3, n, 6))
        self._memory = np.zeros((n, 6, 2))

    @property
    def raw(self) -> Array:
        """The newest unfiltered samples [N, N·m] after the tare, shape (n, 6)."""
        return self._raw - self._offset

    @property
    def passed(self) -> Array:
        """The newest filtered samples [N, N·m] after the tare, shape (n, 6)."""
        return self._passed - self._offset

    def zero(self, rows: Indices) -> None:
        """Tare copies: subtract the current filtered sample from all later samples."""
        self._offset[rows] = self._passed[rows]

    def restart(self, rows: Indices) -> None:
        """Restart the filter of copies with a new sample.

        The copies' cores must be up to date.
        """
        raw = self._measured(rows, None)
        b0, _, a2 = self._filter
        self._memory[rows] = np.stack([(1.0 - b0) * raw, (b0 - a2) * raw], axis=-1)
        self._take(rows, raw)

    def tick(self, ticks: NDArray[np.int64], steps: Addresses) -> None:
        """Advance copies by ``ticks``, shape (n,), and take the samples that are due.

        ``steps`` are the addresses of the last steps in the kernel, shape (n, 3), as
        required by ``ToolMeter.wrenches``.  The addresses are 0 for a copy whose last
        step is in its core.
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
        """Return the wrenches [N, N·m] in the last steps of these copies, (k, 6)."""
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
