"""Where the scene's objects are in MuJoCo and how they move: read, placed, put back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

from tool0.description.scene import Scene
from tool0.description.transform import pose_matrix
from tool0.engines.mujoco.model import quat_wxyz
from tool0.engines.mujoco.objects import free_joint_name
from tool0.errors import EngineError, did_you_mean
from tool0.hardware.engine import ObjectState

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@final
class ObjectStates:
    """Reads from the state itself: ``xpos`` would be that of the step before.

    A free joint has its velocity in the axes of the world, its rate of turning in
    those of the object; outside, both are in the axes of the robot's root.
    """

    def __init__(self, model: Any, data: Any, scene: Scene) -> None:
        """Look into ``model`` and ``data``, which must be the scene's."""
        self._model = model
        self._data = data
        self.names = tuple(item.name for item in scene.objects)
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
        self._homes = {
            item.name: ObjectState(
                item.name,
                item.pose.xyz,
                _four(quat_wxyz(pose_matrix(item.pose)).tolist()),
            )
            for item in scene.objects
            if item.mass is None
        }
        self._still = dict(self._homes)

    def read(self) -> tuple[ObjectState, ...]:
        """Return how each object is, in the scene's order."""
        if not self._starts:
            return tuple(self._still.values())
        position, velocity = self._position.tolist(), self._velocity.tolist()
        starts, still = self._starts, self._still
        return tuple(
            still[name]
            if name in still
            else _state(name, position, velocity, *starts[name])
            for name in self.names
        )

    def place(self, state: ObjectState) -> None:
        """Put an object somewhere, moving so, or raise EngineError."""
        self.check_there(state.name)
        if state.name in self._starts:
            i, j = self._starts[state.name]
            w, x, y, z = state.quat_wxyz
            turning = _turned((w, -x, -y, -z), state.angular)
            self._position[i : i + 7] = (*state.position, *state.quat_wxyz)
            self._velocity[j : j + 6] = (*state.linear, *turning)
            self._warm_start[j : j + 6] = 0.0
        elif any((*state.linear, *state.angular)):
            raise EngineError(
                f"object '{state.name}' has no mass and stands still; "
                "place it without a velocity"
            )
        else:
            self._put(state)

    def put_back(self) -> None:
        """Put what stands still where it began; the rest is MuJoCo's reset's."""
        for state in self._homes.values():
            self._put(state)

    def take_over(self, other: ObjectStates) -> None:
        """Let what stands still stand where ``other`` has it, if that has it at all."""
        for name in self._still.keys() & other._still.keys():
            self._put(other._still[name])

    def check_there(self, name: str) -> None:
        """Raise EngineError unless there is an object ``name``."""
        if name not in self.names:
            hint = did_you_mean(name, set(self.names))
            raise EngineError(f"there is no object '{name}'{hint}")

    def check_movable(self, name: str) -> None:
        """Raise EngineError unless there is an object ``name`` that has a mass."""
        self.check_there(name)
        if name not in self._starts:
            raise EngineError(
                f"object '{name}' has no mass and stands still; only what moves can "
                "be attached"
            )

    def _put(self, state: ObjectState) -> None:
        body = self._model.body(state.name)
        body.pos[:], body.quat[:] = state.position, state.quat_wxyz
        self._still[state.name] = state


def _state(
    name: str, position: list[float], velocity: list[float], i: int, j: int
) -> ObjectState:
    x, y, z, qw, qx, qy, qz = position[i : i + 7]
    vx, vy, vz, wx, wy, wz = velocity[j : j + 6]
    quat = qw, qx, qy, qz
    return ObjectState(name, (x, y, z), quat, (vx, vy, vz), _turned(quat, (wx, wy, wz)))


def _turned(quat: Quaternion, vector: Vector3) -> Vector3:
    """Return ``vector``, given in the frame that ``quat`` turns, in the one around."""
    w, x, y, z = quat
    a, b, c = vector
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a + w * p + y * r - z * q,
        b + w * q + z * p - x * r,
        c + w * r + x * q - y * p,
    )


def _four(values: list[float]) -> Quaternion:
    w, x, y, z = values
    return w, x, y, z
