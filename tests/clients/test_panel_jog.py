"""A page that jogs the tool, and its connection: the arm stops with it."""

from __future__ import annotations

import socket
import struct
import time

import numpy as np
import pytest
from browser import comes_to_rest, eventually
from page import Page, page_at

import tool0
from tool0.api.recording import Recording
from tool0.panel.server import Panel

STOPPING = 0.025
"""As the page brakes: from any speed [s]."""
VALIDITY = 0.04
"""Of each of its commands [s]."""
BOUND = 0.1
"""Within which the tool stops [s]."""
CREEP = 0.5e-3
"""What it may still move after that [m]."""


def jog(page: Page, robot: tool0.Robot, speed: float, duration: float = 0.4) -> float:
    """Jog downwards; return the simulated time at which the last command went out."""
    assert page.request("take_arm", by="panel") is None
    start = robot.time
    while robot.time < start + duration:
        page.send(
            "speed_tool",
            twist=[0.0, 0.0, -speed, 0.0, 0.0, 0.0],
            acceleration=speed / STOPPING,
            duration=VALIDITY,
        )
        time.sleep(0.01)  # the rate of a page, not a wait
    return robot.time


def cut(page: Page) -> None:
    """End the connection as a crash does: a reset, without a farewell."""
    linger = struct.pack("ii", 1, 0)
    raw = page.socket.socket
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
    raw.shutdown(socket.SHUT_RDWR)
    raw.close()


def heights(robot: tool0.Robot, record: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return the times of samples, and how high tool0 was [m]."""
    from tool0.kinematics.chain import find_chains

    chain = find_chains(robot.simulation.description.model)["arm"]
    columns = [record.joint_names.index(name) for name in chain.joint_names]
    posture = chain.forward(record.position[:, columns])
    return record.time, posture.T_base_tip[:, 2, 3]


@pytest.mark.parametrize(
    ("is_cut", "speeds"), [(True, (0.005, 0.1, 0.25)), (False, (0.05, 0.25))]
)
def test_the_tool_stops_at_every_speed_when_the_connection_drops(
    robot: tool0.Robot, panel: Panel, is_cut: bool, speeds: tuple[float, ...]
) -> None:
    comes_to_rest(robot)
    for speed in speeds:
        with robot.record(rate=500) as record, page_at(panel.url) as page:
            dropped = jog(page, robot, speed)
            if is_cut:
                cut(page)
            # otherwise the page only falls silent
            eventually(lambda at=dropped: robot.time > at + 0.5, "time passes")
            if not is_cut:
                cut(page)  # a farewell would wait until the unread frames are read
        times, height = heights(robot, record)
        assert height[0] - height.min() > 0.1 * speed  # it moved
        stopped = height[times > dropped + BOUND]
        assert np.ptp(stopped) < CREEP, (speed, np.ptp(stopped))
        eventually(
            lambda: not robot.arm.control_box.state.taken_by, "the arm is released"
        )
        comes_to_rest(robot)
