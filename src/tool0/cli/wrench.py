"""``tool0 wrench``: what the tool of a running bringup exerts on the flange."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from tool0.cli.connection import Bringup
from tool0.cli.parsing import parse
from tool0.errors import ConfigError
from tool0.sensing.force_torque import DEFAULT_CUTOFF

if TYPE_CHECKING:
    from tool0.api.sensors import ForceTorque
    from tool0.description.transform import Vector3
    from tool0.sensing.force_torque import WrenchReading

_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    parse(wrench, command, arguments)
    return 0


def wrench(
    *,
    zero: bool = False,
    rate: float | None = None,
    cutoff: float | None = None,
    duration: float | None = None,
    raw: bool = False,
    bringup: Bringup = _DEFAULT,
) -> None:
    """Print force and torque that the tool exerts on tool0, in its axes.

    Its weight, its inertia and what presses on it; once, or every sample for a while.

    Args:
        zero: Call what is felt now zero first; --rate or --cutoff forget that.
        rate: Sample so often from now on [Hz]: 50 to 1000; 125 at first.
        cutoff: Of the low-pass filter from now on [Hz]; 15 at first.
        duration: Print every sample for so many simulated seconds; Ctrl-C ends it.
        raw: Print what is not filtered.
        bringup: Which bringup.
    """
    if duration is not None and not duration >= 0.0:
        raise ConfigError(f"--duration must be 0 or more seconds, got {duration}")
    with bringup.connect() as robot:
        sensor = robot.force_torque
        if rate is not None or cutoff is not None:
            sensor.start(rate, DEFAULT_CUTOFF if cutoff is None else cutoff)
        if zero:
            sensor.zero()
        for reading in _readings(sensor, duration or 0.0):
            print(_line(reading, raw), flush=True)


def _readings(sensor: ForceTorque, duration: float) -> Iterator[WrenchReading]:
    """Yield the newest sample, and those of the time after it."""
    newest = sensor.read()
    end = newest.time + duration - 1e-6
    yield newest
    while newest.time < end:
        for reading in sensor.samples(newest.number, None):
            if newest.time < end:
                newest = reading
                yield newest


def _line(reading: WrenchReading, raw: bool) -> str:
    force = reading.raw_force if raw else reading.force
    torque = reading.raw_torque if raw else reading.torque
    return (
        f"t = {reading.time:.3f} s  force {_numbers(force, 2)} N"
        f"  torque {_numbers(torque, 4)} N·m  {reading.frame}"
    )


def _numbers(values: Vector3, digits: int) -> str:
    rounded = (round(value, digits) + 0.0 for value in values)  # no -0.00
    return " ".join(f"{value:+{digits + 5}.{digits}f}" for value in rounded)
