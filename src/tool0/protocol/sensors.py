"""Cameras and force-torque sensors: their values, and the requests to them."""

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
    """An image with depth."""

    time: float
    """Simulated time [s]."""
    rgb: NDArray[np.uint8]
    """Colours, shape (height, width, 3); the first row is the top one."""
    depth: NDArray[np.float32]
    """Distance along the camera's z [m], shape (height, width), as REP-118 has it:
    infinite where there is nothing up to ``camera.far``."""
    K: NDArray[np.float64]
    """The intrinsics, shape (3, 3): ``Camera.intrinsics``."""
    T_root_camera: Transform
    """The optical frame in the robot's root."""


class CameraRenderer(Protocol):
    """Cameras by name, which draw states.  Any thread may use it."""

    def __iter__(self) -> Iterator[str]: ...

    def __getitem__(self, name: str) -> Camera:
        """Return a camera, or raise RenderError."""

    def newest(self) -> Snapshot:
        """Return the newest snapshot, to draw it."""

    def render(self, camera: Camera, snapshot: Snapshot | None = None) -> CameraImage:
        """Return an image of ``snapshot``, by default the newest, from any camera.

        Raises:
            RenderError: If it cannot draw here, or the robot is closed.
        """


DEFAULT_CUTOFF = 15.0
"""Cutoff of the filter [Hz]: a compromise between fast response to a load and
suppressing vibrations of the arm; not from a data sheet."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class WrenchReading:
    """Wrench of the tool on the flange, averaged over one step of the physics.

    In the axes of ``frame``, at its origin, minus the payload if one was set, and minus
    the reading at the last tare.
    """

    time: float
    """Simulated time at the end of the step [s]."""
    number: int
    """Number of the sample since the sensor was started; a reset does not change it."""
    frame: str
    """Name of the link in whose axes the wrench is."""
    force: Vector3
    """Filtered force [N]."""
    torque: Vector3
    """Filtered torque [N·m]."""
    raw_force: Vector3
    """Unfiltered force [N]."""
    raw_torque: Vector3
    """Unfiltered torque [N·m]."""
    dropped: int = 0
    """Number of samples before this one that were no longer kept; in ``samples()``."""


class ListCameras(Request[tuple[Camera, ...]], frozen=True):
    """Every camera of the robot."""


class TakePicture(Request[CameraImage], frozen=True):
    """The current image of a camera: colour and depth."""

    camera: Name


class WrenchSensorRequest(Request[Response], Generic[Response], frozen=True):
    """The fields of every request about a force-torque sensor."""

    link: Name | None = None
    """The link that carries the tool; the robot's only ``tool0``, if left out."""


class StartForceTorque(WrenchSensorRequest[float], frozen=True):
    """Start sampling the wrench at a link; the response is the rate [Hz]."""

    rate: float | None = None
    """Samples per simulated second [Hz], 50 … 1000 and a divisor of the control rate;
    125 or the next divisor below, if left out."""
    cutoff: float = DEFAULT_CUTOFF
    """Cutoff frequency of the low-pass filter [Hz]."""


class StopForceTorque(WrenchSensorRequest[None], frozen=True):
    """Stop sampling, and forget the tare."""


class ReadForceTorqueRate(WrenchSensorRequest[float], frozen=True):
    """Samples per simulated second [Hz]; 0 while the sensor is not started."""


class TareForceTorque(WrenchSensorRequest[None], frozen=True):
    """Tare the sensor, as UR's ``zero_ftsensor`` does."""


class ReadForceTorque(WrenchSensorRequest[WrenchReading], frozen=True):
    """The newest sample; the first one starts the sensor."""


class ReadForceTorqueSamples(
    WrenchSensorRequest[tuple[WrenchReading, ...]], frozen=True
):
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
    """Width of the picture [pixels]."""
    height: int
    """Height of the picture [pixels]."""
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
