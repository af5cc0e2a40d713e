"""Signals of Modbus units, which are updated periodically for programs.

A signal remains in the control box until it is deleted or replaced, even if the program
that added it has ended, because URCaps depend on this behavior.
"""

from __future__ import annotations

import asyncio
import errno
import struct
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, final

from tool0.devices.modbus_frames import ModbusFunction
from tool0.ur.modbus.client import (
    DISCONNECTED,
    ConnectionProblem,
    DeviceError,
    ModbusClient,
)
from tool0.ur.waiting import within

MAX_SIGNALS: Final = 256
FREQUENCY: Final = 10.0
"""Default rate of updates [wall Hz]."""
MAX_FREQUENCY: Final = 500
WATCHDOG: Final = 2.0
"""Maximum time for which a signal may be invalid before programs are notified [wall
s]."""
PORT: Final = 502


class SignalType(IntEnum):
    """Types of signals, with URScript's numbers."""

    DIGITAL_INPUT = 0
    DIGITAL_OUTPUT = 1
    REGISTER_INPUT = 2
    REGISTER_OUTPUT = 3
    DIGITAL_OUTPUTS = 15
    REGISTER_OUTPUTS = 16
    REGISTERS_READ_AND_WRITTEN = 23

    @property
    def is_digital(self) -> bool:
        """Whether the signal's values are bits."""
        return self in {0, 1, 15}

    @property
    def is_output(self) -> bool:
        """Whether programs can write the signal."""
        return self not in {0, 2}


_READ: Final = {
    SignalType.DIGITAL_INPUT: ModbusFunction.READ_DISCRETE_INPUTS,
    SignalType.DIGITAL_OUTPUT: ModbusFunction.READ_COILS,
    SignalType.DIGITAL_OUTPUTS: ModbusFunction.READ_COILS,
    SignalType.REGISTER_INPUT: ModbusFunction.READ_INPUT,
}
"""Functions that read signals. Types that are not listed are holding registers."""


class WhenStopped(IntEnum):
    """Level of a digital output while no program is running."""

    KEPT = 0
    LOW = 1
    HIGH = 2
    LOW_ELSE_HIGH = 3
    """Low while no program runs, and high while a program runs."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SignalSpec:
    """Location of a signal, and the number of its values."""

    host: str
    port: int
    unit: int
    kind: SignalType
    address: int
    count: int = 1
    """Number of registers or bits to read, or to write if the signal is not read."""
    write_address: int = 0
    write_count: int = 0
    """Number of registers to write for ``REGISTERS_READ_AND_WRITTEN``."""


@final
class Signal:
    """A signal with its newest values, and a task that updates them."""

    def __init__(
        self,
        spec: SignalSpec,
        client: ModbusClient | None,
        is_running: Callable[[], bool],
    ) -> None:
        """Start to update a signal periodically.

        Args:
            spec: Location of the signal.
            client: Client of the unit's address; None if programs must not connect to
                this address.
            is_running: Function that returns whether a program is running.
        """
        self.spec = spec
        self.values: tuple[int, ...] = (0,) * spec.count
        self.device_error = 0
        """Modbus exception code with which the unit refused the last request."""
        self.connection_error = DISCONNECTED
        self.watchdog = WATCHDOG
        self.when_stopped = WhenStopped.KEPT
        self._client = client
        self._is_running = is_running
        self._frequency = FREQUENCY
        self._written: tuple[int, ...] | None = None
        self._valid = time.monotonic()
        self._due = asyncio.Event()
        self._task = asyncio.create_task(self._keep())

    @property
    def invalid_for(self) -> float:
        """Time for which requests to the unit have failed [wall s]."""
        is_valid = not (self.device_error or self.connection_error)
        return 0.0 if is_valid else time.monotonic() - self._valid

    def write(self, values: Sequence[int]) -> None:
        """Write the first values; the remaining values do not change."""
        written = list(self._written or self.values)
        if self.spec.write_count:
            written = list(self._written or (0,) * self.spec.write_count)
        written[: len(values)] = values
        self._written = tuple(written)
        if not self.spec.write_count:
            self.values = self._written
        self._due.set()

    def set_frequency(self, frequency: float) -> None:
        """Set the update rate [wall Hz]; 0 or less means an update only on request."""
        self._frequency = frequency
        self._due.set()

    def update(self) -> None:
        """Request an update."""
        self._due.set()

    async def close(self) -> None:
        """Stop updating the signal."""
        self._task.cancel()
        await asyncio.wait([self._task])

    async def _keep(self) -> None:
        while True:
            self._due.clear()
            try:
                await self._exchange()
            except DeviceError as error:
                self.device_error, self.connection_error = error.code, 0
            except ConnectionProblem as error:
                self.device_error, self.connection_error = 0, error.code
            else:
                self.device_error = self.connection_error = 0
                self._valid = time.monotonic()
            period = 1.0 / self._frequency if self._frequency > 0 else None
            await within(self._due.wait(), period)

    async def _exchange(self) -> None:
        spec = self.spec
        written = self._output()
        if written is None:
            function = _READ.get(spec.kind, ModbusFunction.READ_HOLDING)
            self._take(await self._send(function, _pair(spec.address, spec.count)))
        elif spec.kind is SignalType.DIGITAL_OUTPUT:
            level = 0xFF00 if written[0] else 0
            await self._send(ModbusFunction.WRITE_COIL, _pair(spec.address, level))
        elif spec.kind is SignalType.REGISTER_OUTPUT and spec.count == 1:
            await self._send(ModbusFunction.WRITE_ONE, _pair(spec.address, written[0]))
        elif spec.kind is SignalType.REGISTERS_READ_AND_WRITTEN:
            start = _pair(spec.address, spec.count)
            data = start + _block(spec.write_address, _words(written), len(written))
            self._take(await self._send(ModbusFunction.READ_AND_WRITE, data))
        elif spec.kind.is_digital:
            data = _block(spec.address, _packed(written), len(written))
            await self._send(ModbusFunction.WRITE_COILS, data)
        else:
            data = _block(spec.address, _words(written), len(written))
            await self._send(ModbusFunction.WRITE, data)

    def _output(self) -> tuple[int, ...] | None:
        """Return the values to write now; None if there are no values to write."""
        choice = self.when_stopped
        is_running = self._is_running()
        if choice is WhenStopped.LOW_ELSE_HIGH:
            return (int(is_running),) * self.spec.count
        if choice is WhenStopped.KEPT or is_running:
            return self._written
        return (int(choice is WhenStopped.HIGH),) * self.spec.count

    async def _send(self, function: int, data: bytes) -> bytes:
        if self._client is None:
            raise ConnectionProblem(errno.EACCES)
        return await self._client.request(self.spec.unit, function, data)

    def _take(self, response: bytes) -> None:
        """Store the values of a response, which begins with its length."""
        data, count = response[1:], self.spec.count
        if self.spec.kind.is_digital:
            if len(data) * 8 >= count:
                self.values = tuple(data[k // 8] >> k % 8 & 1 for k in range(count))
        elif len(data) == 2 * count:
            self.values = struct.unpack(f">{count}H", data)


@final
class Signals:
    """The signals of a control box, by name."""

    def __init__(self, is_running: Callable[[], bool]) -> None:
        """Create an empty set of signals.

        Args:
            is_running: Function that returns whether a program is running.
        """
        self._is_running = is_running
        self._signals: dict[str, Signal] = {}
        self._clients: dict[tuple[str, int], ModbusClient] = {}

    async def add(
        self, name: str, spec: SignalSpec, *, is_allowed: bool = True
    ) -> None:
        """Add a signal, which replaces any signal with the same name.

        Args:
            name: Name of the signal.
            spec: Location of the signal.
            is_allowed: Whether programs may connect to the unit; if they may not, the
                signal is invalid.

        Raises:
            ValueError: If there are too many signals.
        """
        await self.delete(name)
        if len(self._signals) >= MAX_SIGNALS:
            raise ValueError(f"there are at most {MAX_SIGNALS} signals")
        client = self.client(spec.host, spec.port) if is_allowed else None
        self._signals[name] = Signal(spec, client, self._is_running)

    def find(self, name: str) -> Signal | None:
        """Return the signal with this name, or None."""
        return self._signals.get(name)

    def of_host(self, host: str) -> list[Signal]:
        """Return the signals of the unit at an address."""
        return [item for item in self._signals.values() if item.spec.host == host]

    def client(self, host: str, port: int) -> ModbusClient:
        """Return the client for an address."""
        return self._clients.setdefault((host, port), ModbusClient(host, port))

    async def delete(self, name: str) -> None:
        """Remove a signal if it exists."""
        signal = self._signals.pop(name, None)
        if signal is None:
            return
        await signal.close()
        key = signal.spec.host, signal.spec.port
        others = self._signals.values()
        if not any((item.spec.host, item.spec.port) == key for item in others):
            client = self._clients.pop(key, None)
            if client is not None:
                client.close()

    async def start(self, host: str, port_base: int) -> None:
        """Do nothing, because signals have no port."""

    async def close(self) -> None:
        """Remove all signals."""
        for name in tuple(self._signals):
            await self.delete(name)
        for client in self._clients.values():
            client.close()


def _pair(first: int, second: int) -> bytes:
    return struct.pack(">HH", first, second)


def _block(address: int, data: bytes, count: int) -> bytes:
    return _pair(address, count) + bytes([len(data)]) + data


def _words(values: Sequence[int]) -> bytes:
    return struct.pack(f">{len(values)}H", *values)


def _packed(bits: Sequence[int]) -> bytes:
    total = sum(bit << k for k, bit in enumerate(bits))
    return total.to_bytes((len(bits) + 7) // 8, "little")
