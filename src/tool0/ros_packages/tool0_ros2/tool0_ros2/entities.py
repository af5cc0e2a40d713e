"""The objects around the robot as entities of simulation_interfaces."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree

from tool0_ros2 import requests
from tool0_ros2.bridge import Context
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.copied import Transform, Vector3, from_quaternion
from tool0_ros2.kinematics import LinkTree
from tool0_ros2.messages import fill_frame
from tool0_ros2.requests import StateMessage

_UNSUPPORTED, _NOT_FOUND, _FAILED = 0, 2, 4
"""Result codes of simulation_interfaces/Result."""
_NAME_NOT_UNIQUE, _NAME_INVALID, _UNSUPPORTED_FORMAT, _NO_RESOURCE = 101, 102, 103, 104
_NAMESPACE_INVALID, _PARSE_ERROR, _INVALID_POSE = 105, 106, 109
"""Result codes of SpawnEntity."""
_INVALID_STATE_POSE = 101
"""Result code of SetEntityState."""
_MAX_FILE = 1_000_000
"""Size of the largest file that is read [bytes]."""
_IDENTITY = Transform()


class RefusedError(Exception):
    """Raised to answer a service call with a result code other than success."""

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code = code


class _Object(NamedTuple):
    """State of a scene object in the frame of the robot's root."""

    pose: Transform
    linear: list[float]
    """Linear velocity of the object [m/s]."""
    angular: list[float]
    """Angular velocity of the object [rad/s]."""


class Entities:
    """Spawns, deletes, lists and moves entities, including the robot's entity.

    The pose of an entity is the pose of its model's frame.  By default, the pose is
    given in the frame of the robot's root.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        urdf = context.description["urdf"]
        self._tree = LinkTree(urdf)
        self._robot = ElementTree.fromstring(urdf).get("name") or "robot"
        self._spawned: dict[str, Transform] = {}
        """For each entity that these services spawned, by name: the pose of the object
        in its model's frame."""

    def list_names(self, request: Any, response: Any) -> None:
        response.entities = self._matching(request.filters, self._snapshot())

    def get_states(self, request: Any, response: Any) -> None:
        snapshot = self._snapshot()
        response.entities = names = self._matching(request.filters, snapshot)
        states = []
        for name in names:
            state = _entity_state()
            self._fill_state(state, name, snapshot)
            states.append(state)
        response.states = states

    def get_state(self, request: Any, response: Any) -> None:
        self._fill_state(response.state, request.entity, self._snapshot())

    def spawn(self, request: Any, response: Any) -> None:
        if request.entity_namespace:
            raise RefusedError(_NAMESPACE_INVALID, "objects have no namespace")
        resource = getattr(request, "entity_resource", request)
        text = resource.resource_string or _file_text(resource.uri)
        snapshot = self._snapshot()
        name = self._free_name(request, text, snapshot)
        T_root_model = self._asked_pose(request.initial_pose, snapshot, _INVALID_POSE)
        try:
            placed = self._context.connection.call(
                requests.add_model(
                    name=name,
                    model=text,
                    xyz=T_root_model.position,
                    quat_wxyz=T_root_model.quat_wxyz,
                )
            )
        except RequestFailedError as error:
            wrong = error.kind in ("DescriptionError", "ModelError")
            code = _PARSE_ERROR if wrong else _FAILED
            raise RefusedError(code, str(error)) from None
        self._spawned[name] = from_quaternion(placed["xyz"], placed["quat_wxyz"])
        response.entity_name = name

    def delete(self, request: Any, response: Any) -> None:
        self._object(request.entity, self._snapshot())
        self._context.connection.call(requests.remove_object(name=request.entity))
        self._spawned.pop(request.entity, None)

    def delete_spawned(self) -> None:
        """Remove the entities that these services spawned and that still exist."""
        present = _objects(self._snapshot())
        for name in self._spawned:
            if name in present:
                self._context.connection.call(requests.remove_object(name=name))
        self._spawned.clear()

    def set_state(self, request: Any, response: Any) -> None:
        """Set the pose and velocity.  The acceleration results from the simulation."""
        name, snapshot = request.entity, self._snapshot()
        now = self._object(name, snapshot)
        state = request.state
        has_pose = getattr(request, "set_pose", True)
        has_twist = getattr(request, "set_twist", True)
        frame = self._frame(state.header.frame_id, snapshot, _INVALID_STATE_POSE)
        shape = now.pose
        if has_pose:
            asked = _pose(state.pose, _INVALID_STATE_POSE)
            shape = frame @ asked @ self._spawned.get(name, _IDENTITY)
        linear: Sequence[float] = now.linear
        angular: Sequence[float] = now.angular
        if has_twist:
            linear = frame.rotate(_vector(state.twist.linear))
            angular = frame.rotate(_vector(state.twist.angular))
        self._context.connection.call(
            requests.place_object(
                name=name,
                xyz=shape.position,
                quat_wxyz=shape.quat_wxyz,
                linear=linear,
                angular=angular,
            )
        )

    # ---- parts ----------------------------------------------------------------------

    def _snapshot(self) -> StateMessage:
        return self._context.connection.call(requests.read_snapshot())

    def _matching(self, filters: Any, snapshot: StateMessage) -> list[str]:
        tags, bounds = filters.tags.tags, filters.bounds.type
        if tags or bounds or filters.categories:
            raise RefusedError(_UNSUPPORTED, "entities are filtered by name only")
        try:
            pattern = re.compile(filters.filter)
        except re.error as error:
            raise RefusedError(_FAILED, f"filter '{filters.filter}': {error}") from None
        names = [self._robot, *_objects(snapshot)]
        return [name for name in names if pattern.search(name)]

    def _object(self, name: str, snapshot: StateMessage) -> _Object:
        if name == self._robot:
            raise RefusedError(
                _FAILED, f"'{name}' is the robot, which is fixed to the world"
            )
        found = _objects(snapshot).get(name)
        if found is None:
            raise RefusedError(_NOT_FOUND, f"there is no entity '{name}'")
        return found

    def _fill_state(self, state: Any, name: str, snapshot: StateMessage) -> None:
        state.header.stamp = self._context.clock.to_ros(snapshot["time"])
        state.header.frame_id = self._context.names.frame(self._tree.root)
        pose = _IDENTITY
        if name != self._robot:
            item, twist = self._object(name, snapshot), state.twist
            T_model_shape = self._spawned.get(name, _IDENTITY)
            pose = item.pose @ T_model_shape.inverse()
            twist.linear.x, twist.linear.y, twist.linear.z = map(float, item.linear)
            x, y, z = map(float, item.angular)
            twist.angular.x, twist.angular.y, twist.angular.z = x, y, z
        fill_frame(state.pose.position, state.pose.orientation, pose)

    def _asked_pose(self, stamped: Any, snapshot: StateMessage, code: int) -> Transform:
        frame = self._frame(stamped.header.frame_id, snapshot, code)
        return frame @ _pose(stamped.pose, code)

    def _frame(self, frame: str, snapshot: StateMessage, code: int) -> Transform:
        """Return the pose of a frame in the frame of the root.

        The frame is a link, an entity or the world.
        """
        if frame in ("", "world", self._robot):
            return _IDENTITY
        for link in self._tree.links:
            if frame in (link, self._context.names.frame(link)):
                values = dict(zip(snapshot["joint_names"], snapshot["position"]))
                return self._tree.pose(link, values)
        item = _objects(snapshot).get(frame)
        if item is None:
            raise RefusedError(
                code, f"there is no frame '{frame}'; use a link or an entity"
            )
        return item.pose @ self._spawned.get(frame, _IDENTITY).inverse()

    def _free_name(self, request: Any, text: str, snapshot: StateMessage) -> str:
        name = request.name or _name_in(text)
        if not name and not request.allow_renaming:
            raise RefusedError(_NAME_INVALID, "the name is empty")
        taken = {self._robot, *_objects(snapshot)}
        if name and name not in taken:
            return name
        if not request.allow_renaming:
            raise RefusedError(_NAME_NOT_UNIQUE, f"there is an entity '{name}' already")
        name = name or "object"
        numbers = (f"{name}_{k}" for k in range(1, len(taken) + 2))
        return next(other for other in numbers if other not in taken)


def _objects(snapshot: StateMessage) -> dict[str, _Object]:
    """Return the objects of the scene, by name."""
    rows = zip(snapshot["scene"], snapshot["objects"], snapshot["object_velocities"])
    return {
        item["name"]: _Object(from_quaternion(*pose), *velocity)
        for item, pose, velocity in rows
    }


def _entity_state() -> Any:
    from simulation_interfaces.msg import EntityState

    return EntityState()


def _file_text(uri: str) -> str:
    """Return the text of a file, given by a ``file://`` URI or an absolute path."""
    if not uri:
        raise RefusedError(_NO_RESOURCE, "give a uri or a resource_string")
    parts = urlparse(uri)
    if parts.scheme not in ("", "file"):
        raise RefusedError(
            _UNSUPPORTED_FORMAT,
            f"'{uri}': only file:// URIs are read; or pass the text",
        )
    try:
        with Path(unquote(parts.path)).open(encoding="utf-8") as file:
            return file.read(_MAX_FILE + 1)
    except (OSError, ValueError) as error:
        raise RefusedError(_NO_RESOURCE, f"'{uri}': {error}") from None


def _name_in(text: str) -> str:
    """Return the name of the model in a document; empty if it is not found."""
    found = re.search(r"<(?:model|robot)\b[^>]*?\bname\s*=\s*['\"]([^'\"]+)", text)
    return found.group(1) if found else ""


def _pose(message: Any, code: int) -> Transform:
    turn = message.orientation
    quat_wxyz = (turn.w, turn.x, turn.y, turn.z)
    length = math.hypot(*quat_wxyz)
    place = _vector(message.position)
    if not 0.0 < length < math.inf or not all(map(math.isfinite, place)):
        raise RefusedError(code, "the pose needs finite numbers and a quaternion")
    return from_quaternion(place, quat_wxyz)


def _vector(message: Any) -> Vector3:
    return message.x, message.y, message.z
