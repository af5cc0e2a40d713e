"""A client's force-torque sensor, with readings that are received through RTDE."""

from __future__ import annotations

from typing import Final, final

from tool0.description.transform import Vector3
from tool0.protocol.state import Six

_NONE: Final = (0.0,) * 6


@final
class RtdeSensor:
    """Newest reading of ``external_force_torque``, which programs can use."""

    def __init__(self) -> None:
        self._offset: Vector3 | None = None
        self._reading: Six = _NONE
        self._tare: Six = _NONE

    @property
    def is_used(self) -> bool:
        """Whether this sensor replaces the wrist's built-in sensor."""
        return self._offset is not None

    def set_offset(self, offset: Vector3 | None) -> None:
        """Use the sensor at a point in the flange's frame [m]; None disables it."""
        self._offset = offset
        self._tare = _NONE

    def read(self, wrench: Six) -> None:
        """Store a reading in the flange's axes [N, N·m]."""
        self._reading = wrench

    def tare(self) -> None:
        """Tare the sensor, so that the newest reading becomes zero."""
        self._tare = self._reading

    @property
    def wrench(self) -> Six:
        """Wrench at the flange in the flange's axes [N, N·m]."""
        x, y, z = self._offset or (0.0, 0.0, 0.0)
        pairs = zip(self._reading, self._tare, strict=True)
        fx, fy, fz, tx, ty, tz = (value - tare for value, tare in pairs)
        torque = (tx + y * fz - z * fy, ty + z * fx - x * fz, tz + x * fy - y * fx)
        return (fx, fy, fz, *torque)
