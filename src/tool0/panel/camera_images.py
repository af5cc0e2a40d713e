"""Camera images for pages, rendered on request and only once for all pages."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, Literal, final

from tool0.protocol.sensors import CameraImage, CameraRenderer
from tool0.recording.png import depth_in_mm, encode_png

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tool0.description.scene import SceneObject
    from tool0.protocol.state import Snapshot

ImageKind = Literal["color", "depth"]

MIN_WIDTH: Final = 64
MAX_WIDTH: Final = 1280
"""Largest width of an image [pixels]."""
_DIGITS: Final = 5
"""Number of decimals of positions [rad | m].  Smaller motions are not visible in
images."""
_THREADS: Final = 4
"""Number of threads that encode images or wait for the rendering thread."""
_LEVEL: Final = 1
"""Compression level of zlib.  This level takes a quarter of the time of the default
level, and the images are 1.5 times as large."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PageImage:
    """An encoded image."""

    number: int
    """Number of the image, which increases whenever the cameras' view changes."""
    time: float
    """Simulated time of the image [s]."""
    png: bytes


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class _Rendering:
    """An image that has been or is being rendered, with its encodings."""

    number: int
    image: asyncio.Future[CameraImage]
    encoded: dict[ImageKind, asyncio.Task[PageImage]] = field(default_factory=dict)


@final
class CameraImages:
    """Renders images in threads; its methods are called only in the event loop."""

    def __init__(self, cameras: CameraRenderer) -> None:
        self._cameras = cameras
        self._threads = ThreadPoolExecutor(_THREADS, "tool0 images")
        self._number = 0
        self._poses: tuple[tuple[float, ...], ...] = ()
        self._scene: tuple[SceneObject, ...] | None = None
        self._renderings: dict[tuple[str, int], _Rendering] = {}
        """Newest rendering by camera and width."""

    def __contains__(self, name: object) -> bool:
        return name in tuple(self._cameras)

    async def image(
        self, name: str, kind: ImageKind, width: int, after: int
    ) -> PageImage | None:
        """Return the current image, or None if its number is ``after``.

        If the image is being rendered when a page requests it, the page receives that
        image.

        Args:
            name: Name of the camera.
            kind: ``color``, or ``depth`` in the format of ``depth_pixels``.
            width: Width of the image [pixels]; the height follows from the camera's
                aspect ratio.
            after: Number of the image that the page already has; 0 if the page has no
                image.

        Raises:
            RenderError: If there is no such camera, or OpenGL is not available.
            ModelError: If MuJoCo does not support one of Gazebo's objects.
        """
        camera = self._cameras[name]
        snapshot = self._cameras.newest()
        self._look(snapshot)
        found = self._renderings.get((name, width))
        if found is None or not self._serves(found, after):
            if after == self._number:
                return None
            height = max(1, round(width * camera.height / camera.width))
            sized = replace(camera, width=width, height=height)
            image = asyncio.get_running_loop().run_in_executor(
                self._threads, self._cameras.render, sized, snapshot
            )
            found = _Rendering(number=self._number, image=image)
            self._renderings[name, width] = found
        if kind not in found.encoded:
            found.encoded[kind] = asyncio.create_task(self._encode(found, kind))
        # A page that disconnects must not cancel the image of other pages.
        return await asyncio.shield(found.encoded[kind])

    def close(self) -> None:
        """Stop rendering new images; images in progress are completed."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _look(self, snapshot: Snapshot) -> None:
        """Increase the number if the cameras' view has changed since the last call."""
        objects = [(*item.position, *item.quat_wxyz) for item in snapshot.objects]
        poses = tuple(
            tuple(round(value, _DIGITS) for value in values)
            for values in (snapshot.position, *objects)
        )
        if snapshot.scene is not self._scene or poses != self._poses:
            self._number += 1
            self._scene, self._poses = snapshot.scene, poses

    def _serves(self, rendering: _Rendering, after: int) -> bool:
        """Return whether a rendering other than ``after`` is current or in progress."""
        if rendering.number == after:
            return False
        return rendering.number == self._number or not rendering.image.done()

    async def _encode(self, rendering: _Rendering, kind: ImageKind) -> PageImage:
        image = await asyncio.shield(rendering.image)
        loop = asyncio.get_running_loop()
        png = await loop.run_in_executor(self._threads, _png, image, kind)
        return PageImage(number=rendering.number, time=image.time, png=png)


def depth_pixels(depth: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return depth [m] as colors (height, width, 3), with red · 256 + green in mm.

    The value is 0 if the depth is unknown or above 65.535 m.  Colors are used because
    browsers decode 16-bit gray images with only 8 bits.
    """
    import numpy as np

    mm = depth_in_mm(depth)
    high, low = (mm >> 8).astype(np.uint8), (mm & 255).astype(np.uint8)
    return np.dstack([high, low, np.zeros_like(low)])


def _png(image: CameraImage, kind: ImageKind) -> bytes:
    pixels = image.rgb if kind == "color" else depth_pixels(image.depth)
    return encode_png(pixels, _LEVEL)
