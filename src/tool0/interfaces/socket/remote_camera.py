"""The cameras of a robot in another process."""

from __future__ import annotations

import base64
import zlib
from typing import TYPE_CHECKING, Any, final

from tool0.description.camera import Camera
from tool0.description.transform import Pose, Transform
from tool0.errors import Tool0Error, TransportError
from tool0.interfaces.socket.requests import Call
from tool0.interfaces.socket.wire import Json

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tool0.sensing.cameras import CameraImage


@final
class RemoteCamera:
    """One camera of another process."""

    def __init__(self, call: Call, name: str) -> None:
        self._call = call
        self.name = name

    def image(self) -> CameraImage:
        """Return what it sees now; it is drawn over there.

        Raises:
            RenderError: If there is no such camera, or no OpenGL.
        """
        answer = self._call("camera.image", name=self.name)
        try:
            return _image(answer)
        except (KeyError, TypeError, ValueError, zlib.error, Tool0Error) as error:
            raise TransportError(
                f"the bringup answered with a broken picture: {error!r}"
            ) from None


def list_cameras(call: Call) -> dict[str, Camera]:
    """Return the cameras by name."""
    found = [_camera(row) for row in call("camera.list")["cameras"]]
    return {camera.name: camera for camera in found}


def _camera(row: Json) -> Camera:
    others = {key: row[key] for key in row if key not in ("xyz", "rpy")}
    pose = Pose(xyz=tuple(row["xyz"]), rpy=tuple(row["rpy"]))
    return Camera(pose=pose, **others)


def _image(answer: Json) -> CameraImage:
    from tool0.sensing.cameras import CameraImage

    camera = _camera(answer["camera"])
    a, b, c = map(tuple, answer["rotation"])
    shape = camera.height, camera.width
    return CameraImage(
        time=answer["time"],
        rgb=_unpack(answer["rgb"], "u1", (*shape, 3)),
        depth=_unpack(answer["depth"], "<f4", shape),
        K=camera.intrinsics,
        T_root_camera=Transform(position=tuple(answer["position"]), rotation=(a, b, c)),
    )


def _unpack(text: str, kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    import numpy as np

    return np.frombuffer(zlib.decompress(base64.b64decode(text)), kind).reshape(shape)
