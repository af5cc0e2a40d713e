"""Exported URScript, executed by tool0's own control box."""

from __future__ import annotations

import socket
import time

from ur_address import free_host

import tool0
from tool0 import Program

TIMEOUT = 60.0
"""[wall s]"""


def run_urscript(robot: tool0.Robot, program: Program) -> None:
    """Let tool0's own control box run a program until it sets output 9."""
    box = robot.arm.control_box
    box.set_digital_output(9, False)
    text = robot.programs.export(program, "urscript")
    host = free_host()
    with tool0.UrController(robot, tool0.UrOptions(host=host)) as controller:
        controller.wait()
        with socket.create_connection((host, 30002), timeout=TIMEOUT) as port:
            port.sendall(text.encode())
            end = time.monotonic() + TIMEOUT
            messages = b""
            while not box.state.digital_outputs[9]:
                messages = messages[-(1 << 16) :] + port.recv(1 << 16)
                assert not box.state.protective_stop
                ended = time.monotonic() > end or b"nothing was touched" in messages
                assert not ended, messages
