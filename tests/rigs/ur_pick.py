"""A pick as a person writes it who has ur_rtde and the gripper's socket, and no more.

``python ur_pick.py HOST X1,Y1 X2,Y2 …`` picks cubes at these places on the table, in
the frame of the robot's base [m], and drops them into the bin.
"""

from __future__ import annotations

import math
import socket
import sys

from rtde_control import RTDEControlInterface

DOWN = [math.pi, 0.0, 0.0]
"""Rotation vector of a tool that points down."""
GRASP, ABOVE, DROP = 0.0025, 0.10, 0.14
"""Heights of the TCP: on a cube, above the cubes, above the bin [m]."""
TCP = [0.0, 0.0, 0.1418, 0.0, 0.0, 0.0]
"""Between the pads, when they are 45 mm apart."""
PLACES = [(x, y) for x in (-0.055, 0.0, 0.055) for y in (-0.055, 0.0, 0.055)]
"""Where cubes are dropped, around the middle of the bin [m]."""
BIN = (-0.50, 0.32)
FAST = {"speed": 1.0, "acceleration": 3.0}
SLOW = {"speed": 0.5, "acceleration": 2.0}
OPEN, CLOSED = 0, 255
MOVING = 0


class Gripper:
    """The URCap's socket."""

    def __init__(self, host: str) -> None:
        self._socket = socket.create_connection((host, 63352))
        self.set("ACT 1 GTO 1 SPE 255 FOR 60")
        while self.get("STA") != 3:
            pass

    def set(self, pairs: str) -> None:
        self._socket.sendall(f"SET {pairs}\n".encode())
        assert self._socket.recv(100) == b"ack"

    def get(self, name: str) -> int:
        self._socket.sendall(f"GET {name}\n".encode())
        return int(self._socket.recv(100).split()[1])

    def move(self, position: int) -> int:
        """Move the fingers; return gOBJ: 2 for an object inside."""
        self.set(f"POS {position}")
        while self.get("PRE") != position or self.get("OBJ") == MOVING:
            pass
        return self.get("OBJ")


def pick(host: str, cubes: list[list[float]]) -> None:
    gripper, arm = Gripper(host), RTDEControlInterface(host)
    arm.setTcp(TCP)
    for k, (x, y) in enumerate(cubes):
        arm.moveJ_IK([x, y, ABOVE, *DOWN], 2.0, 4.0)
        arm.moveL([x, y, GRASP, *DOWN], **SLOW)
        print("gOBJ", gripper.move(CLOSED), flush=True)
        arm.moveL([x, y, DROP, *DOWN], **SLOW)
        dx, dy = PLACES[k % len(PLACES)]
        arm.moveL([BIN[0] + dx, BIN[1] + dy, DROP, *DOWN], **FAST)
        gripper.move(OPEN)
    arm.stopScript()


if __name__ == "__main__":
    pick(sys.argv[1], [[float(x) for x in one.split(",")] for one in sys.argv[2:]])
