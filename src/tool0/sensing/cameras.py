"""The robot's cameras, which render images from snapshots in separate threads.

MuJoCo renders the images for every engine. The images are rendered from snapshots, so
they do not slow down the tick. A GL context can be used by only one thread, so each
thread has a separate renderer.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from threading import Lock
from typing import TYPE_CHECKING, NamedTuple, TypeVar, final

from tool0.description.camera import Camera
from tool0.description.look import Look
from tool0.description.model import RobotModel
from tool0.errors import RenderError, did_you_mean
from tool0.protocol.sensors import CameraImage
from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    from concurrent.futures import Future, ThreadPoolExecutor

    import numpy as np
    from numpy.typing import NDArray

    from tool0.engines.mujoco.rendering import Renderer


Drawn = TypeVar("Drawn")


@final
class View(NamedTuple):
    """Camera, state and appearance of an image."""

    camera: Camera
    state: Snapshot
    look: Look = Look()


@final
class Cameras(Mapping[str, Camera]):
    """The cameras by name. Any thread may use this mapping."""

    def __init__(
        self,
        model: RobotModel,
        cameras: Mapping[str, Camera],
        ground: float | None,
        newest: Callable[[], Snapshot],
        threads: int = 1,
    ) -> None:
        """Prepare the cameras; OpenGL is not used before an image is requested.

        Args:
            model: The robot.
            cameras: Cameras by name.
            ground: Height of the ground in the robot's root frame [m]; None if there is
                no ground.
            newest: Function that returns the newest snapshot.
            threads: Number of threads that render images in parallel.
        """
        self.newest = newest
        """Function that returns the newest snapshot."""
        self._cameras = dict(cameras)
        self._lock = Lock()
        self._painters = [_Painter(model, ground) for _ in range(threads)]
        self._is_closed = False

    def __getitem__(self, name: str) -> Camera:
        """Return a camera; raise RenderError if there is no such camera."""
        if name not in self._cameras:
            hint = did_you_mean(name, list(self._cameras))
            raise RenderError(f"no camera '{name}'{hint}")
        return self._cameras[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._cameras)

    def __len__(self) -> int:
        return len(self._cameras)

    def render(self, camera: Camera, snapshot: Snapshot | None = None) -> CameraImage:
        """Return an image from any camera at ``snapshot`` (the newest by default).

        Raises:
            RenderError: If OpenGL is not available, or the robot is closed.
            ModelError: If MuJoCo does not support an object that Gazebo supports.
        """
        return self.render_all([View(camera, snapshot or self.newest())])[0]

    def render_all(self, views: Sequence[View]) -> list[CameraImage]:
        """Return an image for each view; see ``render``."""
        return self._drawn(_Painter.paint, views)

    def segment_all(self, views: Sequence[View]) -> list[NDArray[np.int32]]:
        """Return the object at each pixel of each view; see ``Renderer.segment``."""
        return self._drawn(_Painter.segment, views)

    def _drawn(
        self, draw: Callable[[_Painter, View], Drawn], views: Sequence[View]
    ) -> list[Drawn]:
        with self._lock:
            if self._is_closed:
                raise RenderError("the robot is closed; its cameras take no images")
            turns = itertools.cycle(self._painters)
            drawn = [
                painter.submit(draw, view)
                for painter, view in zip(turns, views, strict=False)
            ]
        return [image.result() for image in drawn]

    def close(self) -> None:
        """End the threads and release OpenGL; further calls have no effect."""
        with self._lock:
            self._is_closed = True
            painters, self._painters = self._painters, []
        for painter in painters:
            painter.close()


@final
class _Painter:
    """A thread with a renderer; both are created for the first image."""

    def __init__(self, model: RobotModel, ground: float | None) -> None:
        self._model, self._ground = model, ground
        self._thread: ThreadPoolExecutor | None = None
        self._renderer: Renderer | None = None  # used only by the thread

    def submit(
        self, draw: Callable[[_Painter, View], Drawn], view: View
    ) -> Future[Drawn]:
        """Start rendering a view in the thread."""
        if self._thread is None:
            from concurrent.futures import ThreadPoolExecutor

            self._thread = ThreadPoolExecutor(1, "tool0 cameras")
        return self._thread.submit(draw, self, view)

    def close(self) -> None:
        """End the thread after all images that it has started have been rendered."""
        if self._thread is not None:
            ended = self._thread.submit(self._end)
            self._thread.shutdown()
            ended.result()

    def paint(self, view: View) -> CameraImage:
        """Return an image of a view; this method runs in the thread."""
        camera, state, look = view
        rgb, depth, frame = self._fitting(camera).render(
            camera, _positions(state), state.scene, state.objects, look
        )
        return CameraImage(
            time=state.time,
            rgb=rgb,
            depth=depth,
            K=camera.intrinsics,
            T_root_camera=frame,
        )

    def segment(self, view: View) -> NDArray[np.int32]:
        """Return the object at each pixel; this method runs in the thread."""
        camera, state, _ = view
        return self._fitting(camera).segment(
            camera, _positions(state), state.scene, state.objects
        )

    def _fitting(self, camera: Camera) -> Renderer:
        """Return a renderer for images of at least the size of the camera's images."""
        from tool0.engines.mujoco.gl import import_mujoco

        import_mujoco()
        from tool0.engines.mujoco.rendering import Renderer

        width, height = camera.width, camera.height
        old = self._renderer
        if old is not None:
            if old.holds(width, height):
                return old
            width, height = max(width, old.size[0]), max(height, old.size[1])
        self._end()
        self._renderer = Renderer(self._model, self._ground, width, height)
        return self._renderer

    def _end(self) -> None:
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def _positions(state: Snapshot) -> dict[str, float]:
    return dict(zip(state.joint_names, state.position, strict=True))
