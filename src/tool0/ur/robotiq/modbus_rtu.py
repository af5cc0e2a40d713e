"""Modbus RTU on a pseudo-terminal that clients open as a serial port.

The frames follow "MODBUS over Serial Line Specification V1.02" (https://modbus.org). A
pseudo-terminal has no baud rate and does not preserve pauses. The length of a frame is
therefore determined from its function code, not from the silence after the frame.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import os
import termios
import tty
from pathlib import Path
from typing import Final, final

from tool0.devices.modbus_frames import ModbusFunction, checksum
from tool0.ur.robotiq.gripper import RobotiqGripper
from tool0.ur.robotiq.modbus import respond

SLAVE: Final = 9
"""The gripper's factory-set slave address."""
BROADCAST: Final = 0
MIN_FRAME: Final = 4
MAX_FRAME: Final = 256
"""Maximum size of a frame [bytes]."""
PAUSE: Final = 0.05
"""Time without data that ends a frame of unknown length [wall s]."""


def frame_length(frame: bytes) -> int | None:
    """Return the length of the request at the start of ``frame`` [bytes].

    The length is None if it cannot be determined, or if more data is needed.
    """
    if len(frame) < 2:
        return None
    match frame[1]:
        case (
            ModbusFunction.READ_HOLDING
            | ModbusFunction.READ_INPUT
            | ModbusFunction.WRITE_ONE
        ):
            return 8
        case ModbusFunction.WRITE if len(frame) > 6:
            return 9 + frame[6]
        case ModbusFunction.READ_AND_WRITE if len(frame) > 10:
            return 13 + frame[10]
        case _:
            return None


@final
class RtuReceiver:
    """Finds the requests in a stream of bytes and answers them."""

    def __init__(self, gripper: RobotiqGripper) -> None:
        self._gripper = gripper
        self._received = b""

    def take(self, data: bytes) -> bytes:
        """Add received data and return the answers to all complete requests."""
        self._received += data
        answers = b""
        while (length := frame_length(self._received)) is not None:
            if len(self._received) < length <= MAX_FRAME:
                break
            frame = self._received[:length]
            if length <= MAX_FRAME and checksum(frame[:-2]) == frame[-2:]:
                answers += self._answer(frame)
                self._received = self._received[length:]
            else:
                self._received = self._received[1:]  # a frame may begin at any byte
        self._received = self._received[-MAX_FRAME:]
        return answers

    def pause(self) -> bytes:
        """Return the answers to data before a period of silence, which may be empty."""
        answers = b""
        while frame := self._received:
            if len(frame) >= MIN_FRAME and checksum(frame[:-2]) == frame[-2:]:
                self._received = b""
                answers += self._answer(frame)
            else:
                self._received = frame[1:]
                answers += self.take(b"")
        return answers

    def _answer(self, frame: bytes) -> bytes:
        address, request = frame[0], frame[1:-2]
        if address not in {SLAVE, BROADCAST} or not self._gripper.is_powered:
            return b""
        response = respond(self._gripper, request)
        if address == BROADCAST:
            return b""
        return (answer := bytes([SLAVE]) + response) + checksum(answer)


@final
class ModbusRtu:
    """A pseudo-terminal to which the gripper is connected, and a link to its file."""

    def __init__(self, gripper: RobotiqGripper, link: Path) -> None:
        """Prepare the terminal without opening it.

        Args:
            gripper: The gripper.
            link: Path that clients open: a symbolic link that exists while the terminal
                is open.
        """
        self.link = link
        self._receiver = RtuReceiver(gripper)
        self._ends: tuple[int, int] | None = None
        self._timer: asyncio.TimerHandle | None = None

    def open(self) -> None:
        """Open the terminal."""
        ours, theirs = self._ends = os.openpty()
        # Both ends remain open, because reading fails if no process has opened the
        # client's end.
        tty.setraw(theirs)
        os.set_blocking(ours, False)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(theirs))
        asyncio.get_running_loop().add_reader(ours, self._read, ours, theirs)

    def close(self) -> None:
        """Remove the link and close the terminal."""
        ends, self._ends = self._ends, None
        if ends is None:
            return
        asyncio.get_running_loop().remove_reader(ends[0])
        if self._timer is not None:
            self._timer.cancel()
        self.link.unlink(missing_ok=True)
        for end in ends:
            os.close(end)

    def _read(self, ours: int, theirs: int) -> None:
        if self._timer is not None:
            self._timer.cancel()
        # A client may request exclusive access, which would remain after the client has
        # closed the file.
        fcntl.ioctl(theirs, termios.TIOCNXCL)
        self._send(ours, self._receiver.take(os.read(ours, MAX_FRAME)))
        loop = asyncio.get_running_loop()
        self._timer = loop.call_later(
            PAUSE, lambda: self._send(ours, self._receiver.pause())
        )

    def _send(self, ours: int, answers: bytes) -> None:
        # Unread data is lost, as on a serial line.
        with contextlib.suppress(BlockingIOError):
            os.write(ours, answers)
