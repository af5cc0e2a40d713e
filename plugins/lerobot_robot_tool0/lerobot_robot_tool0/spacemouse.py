"""A SpaceMouse of 3Dconnexion, by its HID reports."""

from __future__ import annotations

import importlib
import struct
import sys
import time
from collections.abc import Callable, Sequence
from typing import Final, Protocol, final

import numpy as np

from lerobot_robot_tool0.device import Array, Command, beyond_dead_zone
from tool0.errors import ControlError

# The reports: https://andunhh.github.io/spacemouse/SpaceMouseWireless.html has the
# descriptor, with x right, y towards the user and z down.  Older devices send the turns
# in a report of their own: https://github.com/johnhw/pyspacenavigator.
FULL: Final = 350
"""The largest deflection, in counts."""
_MOVE, _TURN, _BUTTONS = 1, 2, 3
"""Numbers of the reports."""
_SILENCE: Final = 0.1
"""A deflected cap reports every 16 ms or faster; silence for so long counts as neutral
[wall s]."""
_RETRY: Final = 1.0
"""Between two looks for a device that is unplugged [wall s]."""
_VENDORS: Final = (0x256F, 0x046D)
"""3Dconnexion, and Logitech, whose name its older devices have."""
_MULTI_AXIS: Final = (0x01, 0x08)
"""Usage page and usage: a multi-axis controller."""
_LENGTH: Final = 64
"""Longest report of USB's full speed [bytes]."""
_ROBOT_AXES: Final = [1, 0, 2]
"""Forward, left and up are against y, x and z of the device."""


class HidDevice(Protocol):
    """The part of hidapi's device that is used here."""

    def read(self, max_length: int) -> Sequence[int]:
        """Return the next report, nothing without one, or raise OSError."""

    def close(self) -> None:
        """Let go of it."""


@final
class SpaceMouse:
    """The deflection of the cap; the left button closes the gripper, the right opens.

    The cap returns to its centre by itself: that is the dead-man switch.
    """

    def __init__(
        self, dead_zone: float, open_device: Callable[[], HidDevice] | None = None
    ) -> None:
        """Open the first one.

        Args:
            dead_zone: Deflection that counts as none, part of the largest one.
            open_device: Opens it, or raises ControlError; hidapi, if left out.

        Raises:
            ControlError: If there is none, or it may not be read.
        """
        self._dead_zone = dead_zone
        self._open = open_device or open_hid
        self._device: HidDevice | None = self._open()
        self._lost = 0.0
        self._reset()

    def read(self) -> Command | None:
        """Return the command now; None while it is unplugged."""
        now = time.monotonic()
        if self._device is None:
            self._reopen(now)
            return None
        self._pressed = 0
        try:
            while report := self._device.read(_LENGTH):
                if self._take(bytes(report)):
                    self._heard = now
        except OSError:
            self._device.close()
            self._device, self._lost = None, now
            return None
        if now - self._heard > _SILENCE:
            self._counts[:] = 0.0
        axes = -self._counts.reshape(2, 3)[:, _ROBOT_AXES].ravel() / FULL
        return Command(
            shares=beyond_dead_zone(axes, self._dead_zone),
            grip="close"
            if self._pressed & 1
            else "open"
            if self._pressed & 2
            else None,
        )

    def close(self) -> None:
        """Let go of it."""
        if self._device is not None:
            self._device.close()
        self._device = None

    def _reset(self) -> None:
        self._counts: Array = np.zeros(6)
        self._buttons = self._pressed = 0
        self._heard = -np.inf

    def _reopen(self, now: float) -> None:
        if now - self._lost < _RETRY:
            return
        self._lost = now
        try:
            self._device = self._open()
        except ControlError:
            return
        self._reset()

    def _take(self, report: bytes) -> bool:
        """Note a report; return whether it has deflections."""
        number, values = report[0], report[1:]
        if number == _BUTTONS:
            buttons = int.from_bytes(values, "little")
            self._pressed |= buttons & ~self._buttons
            self._buttons = buttons
        if number not in (_MOVE, _TURN) or len(values) < 6:
            return False
        first = 0 if number == _MOVE else 3
        count = 6 if number == _MOVE and len(values) >= 12 else 3
        found = struct.unpack_from(f"<{count}h", values)
        self._counts[first : first + count] = found
        return True


def open_hid() -> HidDevice:
    """Return the first SpaceMouse of this machine, opened to read without waiting.

    Raises:
        ControlError: If there is none, or it may not be read.
    """
    # on Linux, hidapi's other backend takes the device from the kernel and needs root
    hid = importlib.import_module("hidraw" if sys.platform == "linux" else "hid")
    found = [
        item
        for vendor in _VENDORS
        for item in hid.enumerate(vendor)
        if (item["usage_page"], item["usage"]) == _MULTI_AXIS
    ]
    if not found:
        raise ControlError("no SpaceMouse is plugged in")
    device = hid.device()
    try:
        device.open_path(found[0]["path"])
    except OSError as error:
        raise ControlError(
            f"'{found[0]['product_string']}' may not be opened ({error}); on Linux a "
            f'rule of udev has to allow it: KERNEL=="hidraw*", '
            f'ATTRS{{idVendor}}=="{found[0]["vendor_id"]:04x}", TAG+="uaccess"'
        ) from error
    device.set_nonblocking(True)
    opened: HidDevice = device
    return opened
