"""Bodies and states of scene objects in MuJoCo.

Each object is a separate body, with a free joint if it has a mass.  Free joints come
after the robot's joints, so that the robot's values are at the beginning of every
array.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, final

import mujoco
import numpy as np

from tool0.description.bodies import Matrix
from tool0.description.model import Collision, RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import (
    Compound,
    Cylinder,
    Geometry,
    Mesh,
    Sphere,
    geometry_names,
    placed_geometries,
)
from tool0.description.transform import (
    pose_matrix,
    rotate_by,
)
from tool0.engines.mujoco.model import (
    GRIP_CONDIM,
    GRIP_SOLIMP,
    GRIP_SOLREF,
    SPINNING,
    add_geom,
    collision_name,
    compile_spec,
    quat_wxyz,
)
from tool0.errors import ModelError
from tool0.hardware.engine import RecordedObjects

OBJECT_SOLREF = (0.004, 1.0)
"""Time constant [s] and damping ratio of contacts between objects, ground and links.
The time constant is a fifth of MuJoCo's default, so that the penetration of a cube at
rest is only micrometers."""
OBJECT_ROLLING = 0.0005
"""Coefficient of rolling friction [m].  The value is an estimate for stiff objects.
With this value, a can on its side does not roll on a table that is tilted by up to one
degree."""

# Values of condim that include spinning friction, and spinning and rolling friction.
_PATCH, _ROUND = 4, 6


def compile_with_scene(
    spec: Any, model: RobotModel, scene: Scene, known_files: Mapping[str, bytes]
) -> tuple[Any, Mapping[str, bytes]]:  # MjSpec and MjModel have no type annotations
    """Return the ``mujoco.MjModel`` of robot and scene, and the contents of mesh files.

    The scene is added to the robot's ``spec``.  ``known_files`` are the contents from
    the previous compilation, since a file can be changed or deleted while its object
    remains.

    Raises:
        ModelError: If MuJoCo rejects the robot or an object.  The message states the
            object.
    """
    _add_objects(spec, model, scene, known_files)
    files = _load_meshes(spec, known_files)
    try:
        return compile_spec(spec), files
    except ModelError:
        for item in scene.objects:
            _compile_alone(item, scene, known_files)
        raise


def _compile_alone(
    item: SceneObject, scene: Scene, known_files: Mapping[str, bytes]
) -> Any:
    """Return the ``mujoco.MjModel`` of one object, or raise ModelError."""
    alone = mujoco.MjSpec()
    _add_object(alone, item, scene, known_files)
    _load_meshes(alone, known_files)
    try:
        return alone.compile()
    except ValueError as error:
        raise ModelError(
            f"MuJoCo rejects object '{item.name}': {error}",
            scene.locations.get(item.name),
        ) from error


def change_body(
    model: Any, item: SceneObject, scene: Scene, known_files: Mapping[str, bytes]
) -> None:
    """Set the mass and size of an object in a compiled model to those of ``item``.

    The shapes of ``item`` must be of the same kinds as the shapes of the object.
    """
    alone = _compile_alone(item, scene, known_files)
    source, target = alone.body(item.name), model.body(item.name)
    for name in ("mass", "inertia"):
        getattr(target, name)[:] = getattr(source, name)
    for geom, _ in _geoms(item):
        i, k = model.geom(geom).id, alone.geom(geom).id
        for values, given in (
            (model.geom_size, alone.geom_size),
            (model.geom_rbound, alone.geom_rbound),
            (model.geom_aabb, alone.geom_aabb),
        ):
            values[i] = given[k]
    ours, its = model.body_bvhadr[target.id], alone.body_bvhadr[source.id]
    if (count := alone.body_bvhnum[source.id]) > 0:
        model.bvh_aabb[ours : ours + count] = alone.bvh_aabb[its : its + count]
    mujoco.mj_setConst(model, mujoco.MjData(model))
    # MuJoCo computes the mean inertia only during compilation; this code adds in the
    # same order.  The tolerance of MuJoCo's solvers is relative to the mean.
    if model.nv:
        model.stat.meaninertia = np.cumsum(model.dof_M0)[-1] / model.nv


def change_friction(
    model: Any, robot: RobotModel, item: SceneObject, scene: Scene
) -> None:
    """Set the friction of an object in a compiled model to that of ``item``."""
    friction = {
        geom: other.friction for other in scene.objects for geom, _ in _geoms(other)
    }
    friction |= {pad: mu for pad, mu in _pads(robot)}
    own = [model.geom(name).id for name, _ in _geoms(item)]
    model.geom_friction[own, 0] = item.friction
    pairs = zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)
    for number, pair in enumerate(pairs):
        if not set(own).isdisjoint(pair):
            mu = min(friction[model.geom(geom).name] for geom in pair)
            model.pair_friction[number, :2] = mu


def _pads(robot: RobotModel) -> list[tuple[str, float]]:
    """Return the name and the friction of each shape of the pads."""
    return [
        (
            collision_name(link, number),
            1.0 if link.surface.mu1 is None else link.surface.mu1,
        )
        for link in robot.links
        if link.surface is not None
        for number in range(len(link.collisions))
    ]


def free_joint_name(name: str) -> str:
    """Return the name of an object's free joint."""
    return f"{name}/free"  # object names do not contain slashes


def _add_objects(
    spec: Any, model: RobotModel, scene: Scene, known_files: Mapping[str, bytes]
) -> None:
    """Add the scene to the robot's spec.

    Between two objects, or between an object and a pad, the smaller friction
    coefficient applies.  These pairs are explicit, since MuJoCo would use the larger
    coefficient.  For contacts with the ground and with other links, the object's
    friction coefficient applies, since it has a higher priority.
    """
    # Static objects come first, since messages about overlaps depend on this order.
    for item in sorted(scene.objects, key=lambda item: item.mass is not None):
        _add_object(spec, item, scene, known_files)
    named = [(item, _geoms(item)) for item in scene.objects]
    for (item, geoms), (pad, mu) in itertools.product(named, _pads(model)):
        for geom, _ in geoms:
            pair = _add_pair(spec, geom, pad, min(item.friction, mu))
            pair.condim = GRIP_CONDIM
            pair.solref, pair.solimp = GRIP_SOLREF, GRIP_SOLIMP
    for (first, ones), (second, others) in itertools.combinations(named, 2):
        if first.mass is None and second.mass is None:
            continue
        mu = min(first.friction, second.friction)
        for (one, shape), (other, its_shape) in itertools.product(ones, others):
            pair = _add_pair(spec, one, other, mu)
            pair.condim = max(_condim(shape), _condim(its_shape))
            pair.solref = OBJECT_SOLREF


def _load_meshes(spec: Any, known: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """Add the contents of the mesh files to ``spec``, and return these contents."""
    files = {}
    assets = {}
    for mesh in spec.meshes:
        name = mesh.file
        if name not in files:
            if name in known:
                files[name] = known[name]
            elif Path(name).is_file():  # otherwise, MuJoCo reports the error
                files[name] = Path(name).read_bytes()
        if name in files:
            # mujoco 3.3.0 does not distinguish files with the same name in different
            # folders.
            mesh.file = name.replace("/", "|").replace("\\", "|")
            assets[mesh.file] = files[name]
    spec.assets = assets
    return files


def _add_object(
    spec: Any, item: SceneObject, scene: Scene, known_files: Mapping[str, bytes]
) -> None:
    frame = pose_matrix(item.pose)
    body = spec.worldbody.add_body(
        name=item.name, pos=frame[:3, 3], quat=quat_wxyz(frame)
    )
    geoms = add_shapes(spec, body, item, np.eye(4))
    if item.mass is None:
        return
    body.add_freejoint(name=free_joint_name(item.name))
    if not isinstance(item.geometry, Compound):
        geoms[0].mass = item.mass
        return
    # The volumes are read from MuJoCo.  The volume of a mesh is that of its convex
    # hull.
    fixed = _compile_alone(replace(item, mass=None), scene, known_files)
    for geom in geoms:
        geom.density *= item.mass / fixed.body(item.name).mass[0]


def add_shapes(spec: Any, body: Any, item: SceneObject, frame: Matrix) -> list[Any]:
    """Add the shapes of an object to a body in which it has the pose ``frame``.

    The function returns the geoms of the shapes.
    """
    geoms = [
        _add_part(spec, body, item, Collision(geometry=shape, origin=pose), frame)
        for shape, pose in placed_geometries(item.geometry)
    ]
    for geom, (name, _) in zip(geoms, _geoms(item), strict=True):
        geom.name = name
    return geoms


def _add_part(
    spec: Any, body: Any, item: SceneObject, part: Collision, frame: Matrix
) -> Any:
    """Add one shape of an object to the object's body, and return the geom."""
    try:
        geom = add_geom(spec, body, part, frame)
    except ModelError as error:
        raise ModelError(f"object '{item.name}': {error.message}") from None
    geom.rgba = item.rgba
    geom.condim = _condim(part.geometry)
    geom.friction = [item.friction, SPINNING, OBJECT_ROLLING]
    geom.solref = OBJECT_SOLREF
    geom.priority = 1
    # With this setting, the mesh is solid like other geoms and is never rejected.
    if isinstance(part.geometry, Mesh):
        mesh = spec.mesh(geom.meshname)
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    return geom


def _add_pair(spec: Any, first: str, second: str, mu: float) -> Any:
    friction = [mu, mu, SPINNING, OBJECT_ROLLING, OBJECT_ROLLING]
    return spec.add_pair(geomname1=first, geomname2=second, friction=friction)


def _condim(geometry: Geometry) -> int:
    return _ROUND if isinstance(geometry, Cylinder | Sphere) else _PATCH


def _geoms(item: SceneObject) -> list[tuple[str, Geometry]]:
    """Return the name and shape of each geom of an object."""
    names = geometry_names(f"{item.name}/object", item.geometry)
    shapes = [shape for shape, _ in placed_geometries(item.geometry)]
    return list(zip(names, shapes, strict=True))


@final
class ObjectStates:
    """Access to poses and velocities of the objects in ``qpos`` and ``qvel``.

    MuJoCo's ``xpos`` is not used, since its values are those of the previous step.  The
    linear velocity of a free joint is in the axes of the world, and its angular
    velocity is in the axes of the object.  In an ``ObjectState``, both velocities are
    in the axes of the robot's root.
    """

    def __init__(self, model: Any, data: Any, scene: Scene) -> None:
        """Access ``model`` and ``data``, which must contain ``scene``."""
        self._model = model
        self.names = tuple(item.name for item in scene.objects)
        movable = [item.name for item in scene.objects if item.mass is not None]
        # The free joints are the last joints, in the order of the scene.  Each free
        # joint has 7 positions and 6 velocities.
        self.starts: Mapping[str, tuple[int, int]] = {
            name: (7 * k, 6 * k) for k, name in enumerate(movable)
        }
        """Index of the first number of each movable object in ``position`` and in
        ``velocity``."""
        self.position = data.qpos[model.nq - 7 * len(movable) :]  # views
        """Positions of the free joints, with 7 numbers per joint."""
        self.velocity = data.qvel[model.nv - 6 * len(movable) :]
        """Velocities of the free joints, with 6 numbers per joint."""
        self._warm_start = data.qacc_warmstart[model.nv - 6 * len(movable) :]
        self._static_at_start = {
            item.name: ObjectState(
                item.name, item.pose.xyz, (*quat_wxyz(pose_matrix(item.pose)).tolist(),)
            )
            for item in scene.objects
            if item.mass is None
        }
        self.static: Mapping[str, ObjectState] = self._static_at_start
        """States of the static objects by name."""

    def is_movable(self, name: str) -> bool:
        """Return whether an object has a mass."""
        return name in self.starts

    def record(self) -> Sequence[ObjectState]:
        """Return the state of each object, in the scene's order.

        This method only copies numbers.  The states are computed when they are read, in
        the thread of the reader.
        """
        if not self.starts:
            return tuple(self.static.values()) if self.static else ()
        position, velocity = self.position.tobytes(), self.velocity.tobytes()
        return RecordedObjects(
            partial(_states, self.names, self.starts, self.static, position, velocity)
        )

    def place(self, state: ObjectState) -> None:
        """Set an object's pose and, unless it is static, its velocity."""
        if state.name not in self.starts:
            self._put(state)
            return
        i, j = self.starts[state.name]
        w, x, y, z = state.quat_wxyz
        angular = rotate_by((w, -x, -y, -z), state.angular)
        self.position[i : i + 7] = (*state.position, *state.quat_wxyz)
        self.velocity[j : j + 6] = (*state.linear, *angular)
        self._warm_start[j : j + 6] = 0.0

    def reset(self) -> None:
        """Move static objects to their start poses; MuJoCo resets movable objects."""
        for state in self._static_at_start.values():
            self._put(state)

    def resume_static(self, states: Mapping[str, ObjectState]) -> None:
        """Move the static objects that are in ``states`` to the poses in ``states``."""
        for name in self.static.keys() & states.keys():
            if self.static[name] != states[name]:
                self._put(states[name])

    def _put(self, state: ObjectState) -> None:
        body = self._model.body(state.name)
        body.pos[:], body.quat[:] = state.position, state.quat_wxyz
        # The mapping is replaced, since records refer to the old mapping.
        self.static = {**self.static, state.name: state}


def _states(
    names: tuple[str, ...],
    starts: Mapping[str, tuple[int, int]],
    static: Mapping[str, ObjectState],
    packed_position: bytes,
    packed_velocity: bytes,
) -> tuple[ObjectState, ...]:
    """Return the state of each object, computed from the numbers of the free joints."""
    position = np.frombuffer(packed_position).tolist()
    velocity = np.frombuffer(packed_velocity).tolist()
    return tuple(
        static[name]
        if name in static
        else _state(name, position, velocity, *starts[name])
        for name in names
    )


def _state(
    name: str, position: list[float], velocity: list[float], i: int, j: int
) -> ObjectState:
    x, y, z, qw, qx, qy, qz = position[i : i + 7]
    vx, vy, vz, wx, wy, wz = velocity[j : j + 6]
    quat = qw, qx, qy, qz
    angular = rotate_by(quat, (wx, wy, wz))
    return ObjectState(name, (x, y, z), quat, (vx, vy, vz), angular)
