"""The methods for cameras, as ``methods.py`` has all others.

Pixels travel as base64 of zlib of the array's bytes, little endian, row by row.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.served_robot import ServedRobot
from tool0.interfaces.socket.wire import Json

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tool0.description.camera import Camera


def _list(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    return {"cameras": [_to_json(view.camera) for view in robot.cameras.values()]}


def _image(robot: ServedRobot, params: Params) -> Json:
    name = params.text("name")
    params.finish()
    view = robot.camera(name)
    image = view.image()
    return {
        "camera": _to_json(view.camera),
        "time": image.time,
        "position": image.T_root_camera.position,
        "rotation": image.T_root_camera.rotation,
        "rgb": _pack(image.rgb),
        "depth": _pack(image.depth),
    }


def _to_json(camera: Camera) -> Json:
    return {
        "name": camera.name,
        "link": camera.link,
        "xyz": camera.pose.xyz,
        "rpy": camera.pose.rpy,
        "width": camera.width,
        "height": camera.height,
        "field_of_view": camera.field_of_view,
        "near": camera.near,
        "far": camera.far,
    }


def _pack(array: NDArray[Any]) -> str:
    little = array.astype(array.dtype.newbyteorder("<"))
    return base64.b64encode(zlib.compress(little.tobytes(), 1)).decode()


CAMERA_CALLS: Final[dict[str, Callable[[ServedRobot, Params], Json]]] = {
    "camera.list": _list,
    "camera.image": _image,
}
