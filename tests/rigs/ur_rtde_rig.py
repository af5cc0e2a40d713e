"""A bring-up in another process, ur_rtde's clients on it, and how a UR moves."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from promised import require_ur_rtde
from rtde_rig import Recorder, ur_bringup

import tool0

Array = NDArray[np.float64]
HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
TIMEOUT = 30.0
"""[wall s]"""
PLAYING = 2
"""Of RTDE's ``runtime_state``."""


class Station:
    """A robot and its clients."""

    def __init__(self, host: str, robot: tool0.Robot) -> None:
        from rtde_control import RTDEControlInterface
        from rtde_receive import RTDEReceiveInterface

        self.host, self.robot = host, robot
        self.receive = RTDEReceiveInterface(host)
        flags = RTDEControlInterface.FLAG_UPLOAD_SCRIPT
        self.control = RTDEControlInterface(host, 500.0, flags)

    def home(self) -> None:
        """Go to the start of a test, with a new program if the last one has ended."""
        if not self.control.isProgramRunning():
            assert self.control.reuploadScript()
            until(self.control.isProgramRunning, "program")
        assert self.control.moveJ(HOME, 3.0, 20.0)
        until(lambda: np.allclose(self.receive.getTargetQ(), HOME, atol=1e-9), "home")

    @property
    def home_pose(self) -> list[float]:
        pose: list[float] = self.control.getForwardKinematics(HOME, [0.0] * 6)
        return pose

    def record(self, *names: str) -> Recorder:
        return Recorder(self.host, *names)


@contextlib.contextmanager
def station_of(*options: str) -> Iterator[Station]:
    """Bring up a robot; yield it with its clients."""
    require_ur_rtde()
    with ur_bringup(*options) as (host, robot):
        yield Station(host, robot)


def until(condition: Callable[[], bool], what: str) -> None:
    """Wait for something that a client can only poll."""
    deadline = time.monotonic() + TIMEOUT
    while not condition():
        assert time.monotonic() < deadline, f"no {what}"
        time.sleep(0.002)


def trapezoid(time: Array, distance: float, speed: float, acceleration: float) -> Array:
    """Return the way at times since the start, by the speed profile of UR's manual."""
    top = min(speed, np.sqrt(acceleration * distance))
    ramp = top / acceleration
    duration = distance / top + ramp
    t = np.clip(time, 0.0, duration)
    rest = duration - t
    return np.where(
        t < ramp,
        0.5 * acceleration * t**2,
        np.where(
            rest < ramp,
            distance - 0.5 * acceleration * rest**2,
            top * (t - 0.5 * ramp),
        ),
    )


def start_of(time: Array, way: Array, acceleration: float) -> float:
    """Return when a motion from rest began, from its first sample that moved."""
    first = int(np.argmax(way > 1e-6))
    return float(time[first] - np.sqrt(2.0 * way[first] / acceleration))


def assert_trapezoid(
    time: Array, way: Array, *, distance: float, speed: float, acceleration: float
) -> None:
    """Compare a recorded way with its formula: within 1 mrad (or mm), and 1 ms.

    Where the motion is fast enough to tell, both have to be met.
    """
    t = time - start_of(time, way, acceleration)
    errors = np.abs(way - trapezoid(t, distance, speed, acceleration))
    assert errors.max() < 1e-3
    rates = np.gradient(trapezoid(t, distance, speed, acceleration), t)
    fast = rates > 0.1 * rates.max()
    assert fast.sum() > 20
    assert (errors[fast] / rates[fast]).max() < 1e-3
