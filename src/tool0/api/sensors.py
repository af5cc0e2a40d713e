"""Handles for cameras and force-torque sensors."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from tool0.api.controller import checked_timeout
from tool0.description.camera import Camera
from tool0.errors import RenderError
from tool0.protocol.channel import Channel, LocalChannel
from tool0.protocol.sensors import (
    DEFAULT_CUTOFF,
    ReadForceTorque,
    ReadForceTorqueRate,
    ReadForceTorqueSamples,
    StartForceTorque,
    StopForceTorque,
    TakePicture,
    TareForceTorque,
    WrenchReading,
)

if TYPE_CHECKING:
    from tool0.protocol.sensors import CameraImage
    from tool0.protocol.state import Snapshot

_LONGEST_WAIT = 0.5
"""Longest wait of one request for a sample [wall s]."""


@final
class ForceTorque:
    """Measures the wrench that a tool exerts on the link that carries it.

    Force [N] and torque [N·m] include the tool's weight, inertia and contacts.  They
    are given in the link's axes at its origin.  Their sign is that of UR's own
    ``wrench`` and of Gazebo's ``child_to_parent`` sensors: a tool that hangs down pulls
    along +z.  The sensor costs nothing until it is started; the first reading starts
    it.  Gazebo reports contacts only after the first request, so its first sample lacks
    them.
    """

    def __init__(self, link: str | None, channel: Channel) -> None:
        self._link = link
        self._channel = channel

    @property
    def link(self) -> str | None:
        """The link that carries the tool; None for the robot's only ``tool0``."""
        return self._link

    @property
    def rate(self) -> float:
        """Samples per simulated second [Hz]; 0 while the sensor is stopped."""
        return self._channel.call(ReadForceTorqueRate(link=self.link))

    def start(self, rate: float | None = None, cutoff: float = DEFAULT_CUTOFF) -> float:
        """Start sampling without a tare and return the rate [Hz].

        A running sensor is restarted.

        Args:
            rate: Samples per simulated second [Hz], 50 … 1000 and a divisor of the
                control rate.  If left out, 125 or the next lower divisor.
            cutoff: Cut-off of the low-pass filter [Hz], below half the rate.

        Raises:
            ControlError: If ``rate`` or ``cutoff`` is out of range.
        """
        request = StartForceTorque(link=self.link, rate=rate, cutoff=cutoff)
        return self._channel.call(request)

    def stop(self) -> None:
        """Stop sampling and forget the tare; stopping twice is allowed."""
        self._channel.call(StopForceTorque(link=self.link))

    def zero(self) -> None:
        """Tare the sensor until it is started again, as UR's ``zero_ftsensor`` does.

        The tare survives a reset of the simulation, as it would in a real sensor.
        """
        self._channel.call(TareForceTorque(link=self.link))

    def read(self) -> WrenchReading:
        """Return the newest sample; the first call starts the sensor.

        Raises:
            ModelError: If there is no such link.
            ControlError: If no link is named, and the robot does not have exactly one
                ``tool0``.
        """
        return self._channel.call(ReadForceTorque(link=self.link))

    def samples(
        self, since: int = -1, timeout: float | None = 0.0
    ) -> tuple[WrenchReading, ...]:
        """Return all samples after ``since``, oldest first.

        The sensor keeps the last 4096 samples, which cover 33 s at 125 Hz and 4 s at 1
        kHz.  If you ask later than that, ``dropped`` of the first returned sample is
        the number of samples that you missed.

        Args:
            since: The ``number`` of the last known sample; a number from before the
                sensor was restarted is ignored.
            timeout: Longest wait for the first sample [wall s]; None for no limit.

        Raises:
            ControlError: If the simulation is closed meanwhile.
            EngineError: If the physics failed.
        """
        longest = checked_timeout(timeout)
        end = time.monotonic() + (math.inf if longest is None else longest)
        while True:
            left = max(0.0, end - time.monotonic())
            request = ReadForceTorqueSamples(
                link=self.link, since=since, timeout=min(left, _LONGEST_WAIT)
            )
            found = self._channel.call(request)
            if found or left == 0.0:
                return found


@final
@dataclass(frozen=True, slots=True, eq=False)
class CameraHandle:
    """One camera of a robot: ``robot.camera(name)``."""

    camera: Camera
    """Pose, image size and field of view of the camera."""
    _channel: Channel

    def image(self, snapshot: Snapshot | None = None) -> CameraImage:
        """Return a colour and depth image of the current state, or of a ``snapshot``.

        Args:
            snapshot: An earlier state to draw instead; only for a simulation in this
                process.

        Raises:
            RenderError: If there is no OpenGL, the robot is closed, or a snapshot is
                given for a robot in another process.
            ModelError: If MuJoCo does not support an object that Gazebo has.
        """
        if snapshot is None:
            return self._channel.call(TakePicture(camera=self.camera.name))
        if not isinstance(self._channel, LocalChannel):
            raise RenderError(
                "a robot in another process draws its newest state only; "
                "leave the snapshot out"
            )
        cameras = self._channel.cameras
        if cameras is None:
            raise RenderError("this robot has no cameras")
        return cameras.render(self.camera, snapshot)
