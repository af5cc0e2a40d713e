"""Requests to cameras and force-torque sensors."""

from __future__ import annotations

import time
import zlib
from typing import Annotated, Any, Generic

from msgspec import Meta, Struct

from tool0.description.camera import Camera
from tool0.description.transform import Transform
from tool0.errors import ControlError
from tool0.requests.table import Name, Request, Response, Vector3, handles
from tool0.runtime.loop import POLL_PERIOD
from tool0.runtime.simulation import Simulation
from tool0.sensing.cameras import CameraImage
from tool0.sensing.force_torque import DEFAULT_CUTOFF, ForceTorqueSensor, WrenchReading


class ListCameras(Request[tuple[Camera, ...]], frozen=True):
    """Every camera of the robot."""


class TakePicture(Request[CameraImage], frozen=True):
    """The current image of a camera: colour and depth."""

    camera: Name


class _OfLink(Request[Response], Generic[Response], frozen=True):
    """The fields of every request about a force-torque sensor."""

    link: Name | None = None
    """The link that carries the tool; the robot's only ``tool0``, if left out."""


class StartForceTorque(_OfLink[float], frozen=True):
    """Start sampling the wrench at a link; the response is the rate [Hz]."""

    rate: float | None = None
    """Samples per simulated second [Hz], 50 … 1000 and a divisor of the control rate;
    125 or the next divisor below, if left out."""
    cutoff: float = DEFAULT_CUTOFF
    """Of the low-pass filter [Hz]."""


class StopForceTorque(_OfLink[None], frozen=True):
    """Stop sampling, and forget the tare."""


class ReadForceTorqueRate(_OfLink[float], frozen=True):
    """Samples per simulated second [Hz]; 0 while the sensor is not started."""


class TareForceTorque(_OfLink[None], frozen=True):
    """Tare the sensor, as UR's ``zero_ftsensor`` does."""


class ReadForceTorque(_OfLink[WrenchReading], frozen=True):
    """The newest sample; the first one starts the sensor."""


class ReadForceTorqueSamples(_OfLink[tuple[WrenchReading, ...]], frozen=True):
    """All samples after one, oldest first.

    The last 4096 are kept; ``dropped`` of the first one says how many are missing.
    """

    since: Annotated[int, Meta(ge=-1)] = -1
    """Number of the last sample that is known already."""
    timeout: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    """Longest wait for the first [wall s]."""


class Picture(Struct, frozen=True, kw_only=True):
    """A camera image as it is sent: arrays row by row, little endian, by zlib."""

    time: float
    """Simulated time [s]."""
    width: int
    """[pixels]"""
    height: int
    """[pixels]"""
    K: tuple[Vector3, Vector3, Vector3]
    """The intrinsics, shape (3, 3)."""
    T_root_camera: Transform
    rgb: bytes
    """uint8, shape (height, width, 3)."""
    depth: bytes
    """float32 [m], shape (height, width)."""


def picture_of(image: CameraImage) -> Picture:
    """Return an image as it is sent."""
    height, width = image.depth.shape
    return Picture(
        time=image.time,
        width=width,
        height=height,
        K=image.K.tolist(),
        T_root_camera=image.T_root_camera,
        rgb=zlib.compress(image.rgb.astype("u1").tobytes(), 1),
        depth=zlib.compress(image.depth.astype("<f4").tobytes(), 1),
    )


def image_of(picture: Picture) -> CameraImage:
    """Return the image that was sent."""
    import numpy as np

    shape = picture.height, picture.width
    rgb = np.frombuffer(zlib.decompress(picture.rgb), "u1").reshape(*shape, 3)
    depth = np.frombuffer(zlib.decompress(picture.depth), "<f4").reshape(shape)
    return CameraImage(
        time=picture.time,
        rgb=rgb,
        depth=depth,
        K=np.array(picture.K),
        T_root_camera=picture.T_root_camera,
    )


handles(ListCameras)(lambda sim, _: tuple(sim.cameras.values()))
handles(TakePicture)(
    lambda sim, request: sim.cameras.render(sim.cameras[request.camera])
)


@handles(StartForceTorque)
def _start(simulation: Simulation, request: StartForceTorque) -> float:
    sensors = simulation.force_torque
    return sensors.start(sensors.link(request.link), request.rate, request.cutoff)


def _sensor(simulation: Simulation, request: _OfLink[Any]) -> ForceTorqueSensor:
    """Return the sensor of a request; the first request starts it."""
    sensors = simulation.force_torque
    return sensors.sensor(sensors.link(request.link))


handles(StopForceTorque)(
    lambda sim, request: sim.force_torque.stop(sim.force_torque.link(request.link))
)
handles(ReadForceTorqueRate)(
    lambda sim, request: sim.force_torque.rate(sim.force_torque.link(request.link))
)
handles(TareForceTorque)(lambda sim, request: _sensor(sim, request).zero())
handles(ReadForceTorque)(lambda sim, request: _sensor(sim, request).latest())


@handles(ReadForceTorqueSamples)
def _samples(
    simulation: Simulation, request: ReadForceTorqueSamples
) -> tuple[WrenchReading, ...]:
    sensor, loop = _sensor(simulation, request), simulation.loop
    end = time.monotonic() + request.timeout
    while True:
        left = max(0.0, end - time.monotonic())
        found = sensor.samples(request.since, min(left, POLL_PERIOD))
        if found or left == 0.0:
            return found
        loop.check()
        if loop.is_closed:
            raise ControlError("the simulation was closed")
