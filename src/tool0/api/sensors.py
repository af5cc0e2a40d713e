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
"""Longest time that one request waits for a sample [wall s]."""


@final
class ForceTorque:
    """Sensor for the wrench that a tool exerts on the link that carries it.

    The force [N] and the torque [N·m] include the weight, the inertia and the contacts
    of the tool.  The wrench is in the frame of the link.  The sign convention is the
    same as for the ``wrench`` of a UR and for the ``child_to_parent`` sensors of
    Gazebo: a tool that hangs down pulls along +z.  The sensor uses no computing time
    until it is started; the first reading starts the sensor.  Gazebo reports contacts
    only after the first request; therefore, the first sample does not include contacts.
    """

    def __init__(self, link: str | None, channel: Channel) -> None:
        self._link = link
        self._channel = channel

    @property
    def link(self) -> str | None:
        """Link that carries the tool; None selects the robot's only ``tool0``."""
        return self._link

    @property
    def rate(self) -> float:
        """Sampling rate in simulated time [Hz]; 0 while the sensor is stopped."""
        return self._channel.call(ReadForceTorqueRate(link=self.link))

    def start(self, rate: float | None = None, cutoff: float = DEFAULT_CUTOFF) -> float:
        """Start sampling without a tare, and return the sampling rate [Hz].

        A running sensor is restarted.

        Args:
            rate: Sampling rate in simulated time [Hz]: 50 … 1000, and a divisor of the
                control rate.  The default is 125 or the next lower divisor.
            cutoff: Cutoff frequency of the low-pass filter [Hz], below half the rate.

        Raises:
            ControlError: If ``rate`` or ``cutoff`` is out of range.
        """
        request = StartForceTorque(link=self.link, rate=rate, cutoff=cutoff)
        return self._channel.call(request)

    def stop(self) -> None:
        """Stop sampling and discard the tare; further calls have no effect."""
        self._channel.call(StopForceTorque(link=self.link))

    def zero(self) -> None:
        """Tare the sensor until its next start, as UR's ``zero_ftsensor`` does.

        As with a real sensor, a reset of the simulation does not change the tare.
        """
        self._channel.call(TareForceTorque(link=self.link))

    def read(self) -> WrenchReading:
        """Return the newest sample; the first call starts the sensor.

        Raises:
            ModelError: If the link does not exist.
            ControlError: If no link is given, and the robot does not have exactly one
                ``tool0``.
        """
        return self._channel.call(ReadForceTorque(link=self.link))

    def samples(
        self, since: int = -1, timeout: float | None = 0.0
    ) -> tuple[WrenchReading, ...]:
        """Return all samples after ``since``, oldest first.

        The sensor keeps the last 4096 samples, which cover 33 s at 125 Hz and 4 s at 1
        kHz.  If more time passes between two calls, ``dropped`` of the first returned
        sample is the number of missed samples.

        Args:
            since: The ``number`` of the last known sample; a number from before a
                restart of the sensor is ignored.
            timeout: Longest wait for the first sample [wall s]; None for no limit.

        Raises:
            ControlError: If the simulation is closed during the wait.
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
        """Return a color and depth image of the current state or of a ``snapshot``.

        Args:
            snapshot: An earlier state to render; only for a simulation in this process.

        Raises:
            RenderError: If OpenGL is not available, if the robot is closed, or if a
                snapshot is given for a robot in another process.
            ModelError: If MuJoCo does not support an object in Gazebo.
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
