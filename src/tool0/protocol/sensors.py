"""Cameras and force-torque sensors: values and requests."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Generic, Protocol, final

from msgspec import Meta, Struct

from tool0.description.camera import Camera
from tool0.description.transform import Transform
from tool0.protocol.request import Name, Request, Response, Vector3

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tool0.protocol.state import Snapshot


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CameraImage:
    """A color image with a depth image."""

    time: float
    """Simulated time [s]."""
    rgb: NDArray[np.uint8]
    """RGB colors, shape (height, width, 3); the first row is the top row of the
    image."""
    depth: NDArray[np.float32]
    """Distance along the camera's z axis [m], shape (height, width), according to REP
    118; infinite if no surface is within ``camera.far``."""
    K: NDArray[np.float64]
    """Intrinsic matrix, shape (3, 3); see ``Camera.intrinsics``."""
    T_root_camera: Transform
    """Pose of the optical frame in the robot's root frame."""


class CameraRenderer(Protocol):
    """Renderer of snapshots, with cameras by name; thread-safe."""

    def __iter__(self) -> Iterator[str]: ...

    def __getitem__(self, name: str) -> Camera:
        """Return a camera; raise RenderError if the camera does not exist."""

    def newest(self) -> Snapshot:
        """Return the newest snapshot, for rendering."""

    def render(self, camera: Camera, snapshot: Snapshot | None = None) -> CameraImage:
        """Return an image of ``snapshot``; the default is the newest snapshot.

        Raises:
            RenderError: If this machine cannot render images, or if the robot is
                closed.
        """


DEFAULT_CUTOFF = 15.0
"""Default cutoff frequency of the filter [Hz].  The value is a compromise between a
fast response to loads and the suppression of arm vibrations; it is not from a data
sheet."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class WrenchReading:
    """Wrench of the tool on the flange, averaged over one step of the physics.

    The wrench is in the axes of ``frame``, at the origin of ``frame``.  The weight and
    the inertia of a set payload, and the reading at the last tare, are subtracted.
    """

    time: float
    """Simulated time at the end of the physics step [s]."""
    number: int
    """Number of the sample since the start of the sensor; a reset does not restart the
    count."""
    frame: str
    """Name of the link in whose frame the wrench is given."""
    force: Vector3
    """Filtered force [N]."""
    torque: Vector3
    """Filtered torque [N·m]."""
    raw_force: Vector3
    """Unfiltered force [N]."""
    raw_torque: Vector3
    """Unfiltered torque [N·m]."""
    dropped: int = 0
    """Number of lost samples before this sample; only in ``samples()``."""


class ListCameras(Request[tuple[Camera, ...]], frozen=True):
    """List the robot's cameras."""


class TakePicture(Request[CameraImage], frozen=True):
    """Render the current color and depth images of a camera."""

    camera: Name


class WrenchSensorRequest(Request[Response], Generic[Response], frozen=True):
    """Common field of requests about a force-torque sensor."""

    link: Name | None = None
    """Link that carries the tool; the default is the only ``tool0`` of the robot."""


class StartForceTorque(WrenchSensorRequest[float], frozen=True):
    """Start sampling the wrench at a link; the response is the rate [Hz]."""

    rate: float | None = None
    """Sampling rate in simulated time [Hz]: 50 … 1000, and a divisor of the control
    rate.  The default is 125 or the next lower divisor."""
    cutoff: float = DEFAULT_CUTOFF
    """Cutoff frequency of the low-pass filter [Hz]."""


class StopForceTorque(WrenchSensorRequest[None], frozen=True):
    """Stop sampling and discard the tare."""


class ReadForceTorqueRate(WrenchSensorRequest[float], frozen=True):
    """Read the sampling rate in simulated time [Hz]; 0 if the sensor is not started."""


class TareForceTorque(WrenchSensorRequest[None], frozen=True):
    """Tare the sensor, as UR's ``zero_ftsensor`` does."""


class ReadForceTorque(WrenchSensorRequest[WrenchReading], frozen=True):
    """Read the newest sample; the first request starts the sensor."""


class ReadForceTorqueSamples(
    WrenchSensorRequest[tuple[WrenchReading, ...]], frozen=True
):
    """Read all samples after a given sample, oldest first.

    The last 4096 samples are kept; ``dropped`` of the first sample is the number of
    lost samples.
    """

    since: Annotated[int, Meta(ge=-1)] = -1
    """Number of the last sample that the caller already has."""
    timeout: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    """Longest wait for the first sample [wall s]."""


class Picture(Struct, frozen=True, kw_only=True):
    """A camera image in the sent form: zlib-compressed, little-endian arrays."""

    time: float
    """Simulated time [s]."""
    width: int
    """Width of the image [pixels]."""
    height: int
    """Height of the image [pixels]."""
    K: tuple[Vector3, Vector3, Vector3]
    """Intrinsic matrix, shape (3, 3)."""
    T_root_camera: Transform
    rgb: bytes
    """RGB colors as uint8, shape (height, width, 3), row by row."""
    depth: bytes
    """Depth as float32 [m], shape (height, width), row by row."""


def picture_of(image: CameraImage) -> Picture:
    """Return the sent form of an image."""
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
    """Return the image that a received ``Picture`` contains."""
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
