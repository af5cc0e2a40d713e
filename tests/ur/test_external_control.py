"""A program of the driver's kind on the control box, and its other end, played here."""

from __future__ import annotations

import math
import socket
import struct
import time
from pathlib import Path

import pytest
from ur_rig import ur_rig

PROGRAM = Path(__file__).parents[1] / "data" / "urscript" / "external_control.script"
RATE = 250  # setpoints per second, at most
DURATION = 3.0  # simulated [s], whatever the machine does
TIMEOUT = 1000  # after which the program ends by itself [ms]
AMPLITUDE = 0.1  # [rad]
FREQUENCY = 0.5  # [Hz]
JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
LONG = 30.0  # [wall s]; only a failing test waits so long


@pytest.fixture(scope="module")
def rig():
    with ur_rig(initial_pose="home") as rig:
        yield rig


def test_setpoints_are_followed_until_they_end(rig) -> None:
    robot = rig.robot
    start = [robot.joint_state.position[name] for name in JOINTS]
    elbow = JOINTS[2]
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        socket.create_connection((rig.host, 30001)) as primary,
    ):
        server.settimeout(LONG)
        text = PROGRAM.read_text().replace("PORT", str(server.getsockname()[1]))
        primary.sendall(b"stop program\n" + text.encode())
        reverse, _ = server.accept()
        with reverse:
            assert reverse.recv(4) == struct.pack(">i", 1)
            errors = []
            began = robot.time
            while (t := robot.time - began) < DURATION:
                offset = AMPLITUDE * (1.0 - math.cos(2.0 * math.pi * FREQUENCY * t))
                goal = [*start[:2], start[2] + offset, *start[3:]]
                ints = [TIMEOUT, *(round(1e6 * q) for q in goal)]
                reverse.sendall(struct.pack(">7i", *ints))
                errors.append(abs(robot.joint_state.position[elbow] - goal[2]))
                time.sleep(1.0 / RATE)
            fastest = 2.0 * math.pi * FREQUENCY * AMPLITUDE
            assert max(errors) < 0.3 * fastest  # 0.3 s behind, on a busy machine
            assert max(errors) > 0.0
            reverse.settimeout(LONG)
            assert reverse.recv(1) == b""  # the program has ended
    assert robot.arm.control_box.state.protective_stop == ""
    assert robot.joint_state.position[elbow] == pytest.approx(goal[2], abs=0.01)
