"""A bring-up in another process, and ur_rtde's clients on it."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

import numpy as np
from promised import require_ur_rtde
from rtde_rig import Recorder, ur_bringup

import tool0

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
