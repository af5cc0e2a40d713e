"""Poses and velocities of the scene's objects in MuJoCo's data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

from tool0.description.scene import Scene
from tool0.description.transform import Quaternion, Vector3, pose_matrix
from tool0.engines.mujoco.model import quat_wxyz
from tool0.engines.mujoco.objects import free_joint_name
from tool0.hardware.engine import ObjectState


@final
class ObjectStates:
    """Reads from the state itself: ``xpos`` would be that of the step before.

    A free joint has its velocity in the axes of the world, its rate of turning in
    those of the object; outside, both are in the axes of the robot's root.
    """

    def __init__(self, model: Any, data: Any, scene: Scene) -> None:
        """View ``model`` and ``data``, which must be the scene's."""
        self._model = model
        self._names = tuple(item.name for item in scene.objects)
        movable = [item.name for item in scene.objects if item.mass is not None]
        joints = {name: model.joint(free_joint_name(name)) for name in movable}
        starts = {
            name: (int(joint.qposadr[0]), int(joint.dofadr[0]))
            for name, joint in joints.items()
        }
        first = min(starts.values(), default=(0, 0))
        self._starts: Mapping[str, tuple[int, int]] = {
            name: (start[0] - first[0], start[1] - first[1])
            for name, start in starts.items()
        }
        self._position = data.qpos[first[0] :]  # views
        self._velocity = data.qvel[first[1] :]
        self._warm_start = data.qacc_warmstart[first[1] :]
        self._static_at_start = {
            item.name: ObjectState(
                item.name,
                item.pose.xyz,
                _quaternion(quat_wxyz(pose_matrix(item.pose)).tolist()),
            )
            for item in scene.objects
            if item.mass is None
        }
        self._static = dict(self._static_at_start)

    def read(self) -> tuple[ObjectState, ...]:
        """Return the state of each object, in the scene's order."""
        if not self._starts:
            return tuple(self._static.values())
        position, velocity = self._position.tolist(), self._velocity.tolist()
        starts, static = self._starts, self._static
        return tuple(
            static[name]
            if name in static
            else _state(name, position, velocity, *starts[name])
            for name in self._names
        )

    def place(self, state: ObjectState) -> None:
        """Set an object's pose and, unless it is static, its velocity."""
        if state.name not in self._starts:
            self._put(state)
            return
        i, j = self._starts[state.name]
        w, x, y, z = state.quat_wxyz
        angular = _rotated((w, -x, -y, -z), state.angular)
        self._position[i : i + 7] = (*state.position, *state.quat_wxyz)
        self._velocity[j : j + 6] = (*state.linear, *angular)
        self._warm_start[j : j + 6] = 0.0

    def reset(self) -> None:
        """Put static objects where they began; MuJoCo resets the others."""
        for state in self._static_at_start.values():
            self._put(state)

    def copy_static_poses(self, other: ObjectStates) -> None:
        """Put static objects where ``other`` has them, if it has them."""
        for name in self._static.keys() & other._static.keys():
            self._put(other._static[name])

    def _put(self, state: ObjectState) -> None:
        body = self._model.body(state.name)
        body.pos[:], body.quat[:] = state.position, state.quat_wxyz
        self._static[state.name] = state


def _state(
    name: str, position: list[float], velocity: list[float], i: int, j: int
) -> ObjectState:
    x, y, z, qw, qx, qy, qz = position[i : i + 7]
    vx, vy, vz, wx, wy, wz = velocity[j : j + 6]
    quat = qw, qx, qy, qz
    angular = _rotated(quat, (wx, wy, wz))
    return ObjectState(name, (x, y, z), quat, (vx, vy, vz), angular)


def _rotated(quat: Quaternion, vector: Vector3) -> Vector3:
    """Return ``vector`` rotated by ``quat``."""
    w, x, y, z = quat
    a, b, c = vector
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a + w * p + y * r - z * q,
        b + w * q + z * p - x * r,
        c + w * r + x * q - y * p,
    )


def _quaternion(values: list[float]) -> Quaternion:
    w, x, y, z = values
    return w, x, y, z
