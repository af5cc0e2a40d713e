"""The methods for the wrench at the wrist, as ``methods.py`` has all others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Final

from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.served_robot import ServedRobot
from tool0.interfaces.socket.wire import Json

LONGEST_WAIT: Final = 1.0
"""For a sample [wall s]: meanwhile the connection answers nothing else."""
MOST_SAMPLES: Final = 500
"""In one answer, half a second's at 1 kHz: a line must not be too long."""


def _start(robot: ServedRobot, params: Params) -> Json:
    rate, cutoff = params.optional_number("rate"), params.optional_number("cutoff")
    params.finish()
    sensor = robot.force_torque
    if cutoff is None:
        sensor.start(rate)
    else:
        sensor.start(rate, cutoff)
    return {"rate": sensor.rate}


def _stop(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    robot.force_torque.stop()
    return {}


def _zero(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    robot.force_torque.zero()
    return {}


def _read(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    return asdict(robot.force_torque.read())


def _samples(robot: ServedRobot, params: Params) -> Json:
    since = int(params.number("since", -1))
    timeout = min(max(0.0, params.number("timeout", 0.0)), LONGEST_WAIT)
    params.finish()
    found = robot.force_torque.samples(since, timeout)
    return {"samples": [asdict(reading) for reading in found[:MOST_SAMPLES]]}


WRENCH_CALLS: Final[dict[str, Callable[[ServedRobot, Params], Json]]] = {
    "wrench.start": _start,
    "wrench.stop": _stop,
    "wrench.zero": _zero,
    "wrench.read": _read,
    "wrench.samples": _samples,
}
