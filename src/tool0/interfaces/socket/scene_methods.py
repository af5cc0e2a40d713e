"""The methods for what is around the robot, as ``methods.py`` has all others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from tool0.description.scene import DEFAULT_FRICTION, RGBA
from tool0.description.shapes import Mesh, mesh
from tool0.description.transform import Pose, to_transform
from tool0.errors import TransportError
from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.served_robot import ServedRobot
from tool0.interfaces.socket.shape_json import shape_from_params, shape_to_json
from tool0.interfaces.socket.wire import Json

_ZERO: Final = (0.0, 0.0, 0.0)


def _list(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    snapshot = robot.snapshot
    rows = [
        {
            "name": item.name,
            "shape": shape_to_json(item.geometry),
            "mass": item.mass,
            "friction": item.friction,
            "position": list(state.position),
            "quat_wxyz": list(state.quat_wxyz),
            "linear": list(state.linear),
            "angular": list(state.angular),
        }
        for item, state in zip(snapshot.scene, snapshot.objects, strict=True)
    ]
    return {"objects": rows}


def _add(robot: ServedRobot, params: Params) -> Json:
    name = params.text("name")
    shape = shape_from_params(params)
    if isinstance(shape, Mesh):
        shape = mesh(shape.path, shape.scale)  # it is there
    xyz, rpy = params.vector("xyz", _ZERO), params.vector("rpy", _ZERO)
    mass = params.optional_number("mass")
    friction = params.number("friction", DEFAULT_FRICTION)
    rgba = _rgba(params)
    params.finish()
    robot.scene.add(
        name, shape, xyz=xyz, rpy=rpy, mass=mass, friction=friction, rgba=rgba
    )
    return {}


def _rgba(params: Params) -> RGBA | None:
    values = params.optional_numbers("rgba")
    if values is None:
        return None
    if len(values) != 4:
        raise TransportError(f"scene.add: 'rgba' has four parts, got {len(values)}")
    red, green, blue, alpha = values
    return red, green, blue, alpha


def _remove(robot: ServedRobot, params: Params) -> Json:
    name = params.text("name")
    params.finish()
    robot.scene.remove(name)
    return {}


def _place(robot: ServedRobot, params: Params) -> Json:
    name = params.text("name")
    pose = Pose(xyz=params.vector("xyz"), rpy=params.vector("rpy", _ZERO))
    params.finish()
    robot.scene.place(name, pose.xyz, to_transform(pose).quat_wxyz)
    return {}


SCENE_CALLS: Final[dict[str, Callable[[ServedRobot, Params], Json]]] = {
    "scene.list": _list,
    "scene.add": _add,
    "scene.remove": _remove,
    "scene.place": _place,
}
