"""The scene's objects in MuJoCo: bodies beside the robot.

Each is a body of its own, on a free joint if it has a mass.  Free joints come after
the robot's, whose values so stay the first of every array.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from tool0.description.model import Collision, RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Cylinder, Mesh, Sphere
from tool0.description.transform import pose_matrix
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

OBJECT_SOLREF = (0.004, 1.0)
"""Of contacts between objects, ground and links: a fifth of MuJoCo's time constant
[s], so that a cube at rest penetrates by micrometres."""
OBJECT_ROLLING = 0.0005
"""Rolling friction [m], a guess for firm things: a can on its side stays where it is
on a table that is up to one degree from level."""

_PATCH, _ROUND = 4, 6  # condim: with spinning friction; with rolling friction, too


def compile_with_scene(
    spec: Any, model: RobotModel, scene: Scene, known_files: Mapping[str, bytes]
) -> tuple[Any, Mapping[str, bytes]]:  # MjSpec and MjModel carry no types
    """Return the ``mujoco.MjModel`` of robot and scene, and its mesh files' contents.

    Args:
        spec: Of the robot; the scene is added to it.
        model: The robot.
        scene: The objects.
        known_files: The contents from the compilation before: a file may change or go
            while the object made of it stays.

    Raises:
        ModelError: If MuJoCo refuses it; if an object is to blame, it is named.
    """
    _add_objects(spec, model, scene)
    files = _load_meshes(spec, known_files)
    try:
        return compile_spec(spec), files
    except ModelError:
        for item in scene.objects:
            alone = mujoco.MjSpec()
            _add_object(alone, item)
            try:
                alone.compile()
            except ValueError as error:
                raise ModelError(
                    f"MuJoCo refuses object '{item.name}': {error}",
                    scene.locations.get(item.name),
                ) from error
        raise


def free_joint_name(name: str) -> str:
    """Return the name of an object's free joint, which no joint of a robot has."""
    return f"{name}/free"  # no object's name has a slash


def object_of(free_joint: str) -> str:
    """Return the name of the object whose joint it is."""
    return free_joint.partition("/")[0]


def _add_objects(spec: Any, model: RobotModel, scene: Scene) -> None:
    """Add the scene to the spec of the robot.

    The smaller friction of two objects, or of an object and a pad, is what counts:
    MuJoCo would take the larger, so these pairs are explicit.  The ground and the
    robot's other links leave it to the object, by its priority over theirs.
    """
    # Static objects come first: messages about overlaps go by this order.
    for item in sorted(scene.objects, key=lambda item: item.mass is not None):
        _add_object(spec, item)
    pads = [
        (collision_name(link, number), link.surface)
        for link in model.links
        if link.surface is not None
        for number in range(len(link.collisions))
    ]
    for item, (pad, surface) in itertools.product(scene.objects, pads):
        mu = 1.0 if surface.mu1 is None else surface.mu1
        pair = _add_pair(spec, _geom_name(item), pad, min(item.friction, mu))
        pair.condim = GRIP_CONDIM
        pair.solref, pair.solimp = GRIP_SOLREF, GRIP_SOLIMP
    for first, second in itertools.combinations(scene.objects, 2):
        if first.mass is not None or second.mass is not None:
            mu = min(first.friction, second.friction)
            pair = _add_pair(spec, _geom_name(first), _geom_name(second), mu)
            pair.condim = max(_condim(first), _condim(second))
            pair.solref = OBJECT_SOLREF


def _load_meshes(spec: Any, known: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """Give ``spec`` the contents of its mesh files, and return them."""
    files = {}
    assets = {}
    for mesh in spec.meshes:
        name = mesh.file
        if name not in files:
            if name in known:
                files[name] = known[name]
            elif Path(name).is_file():  # otherwise MuJoCo reports what is wrong
                files[name] = Path(name).read_bytes()
        if name in files:
            # mujoco 3.3.0 takes two files of one name in two folders for the same.
            mesh.file = name.replace("/", "|").replace("\\", "|")
            assets[mesh.file] = files[name]
    spec.assets = assets
    return files


def _add_object(spec: Any, item: SceneObject) -> None:
    frame = pose_matrix(item.pose)
    body = spec.worldbody.add_body(
        name=item.name, pos=frame[:3, 3], quat=quat_wxyz(frame)
    )
    try:
        geom = add_geom(spec, body, Collision(geometry=item.geometry), np.eye(4))
    except ModelError as error:
        raise ModelError(f"object '{item.name}': {error.message}") from None
    geom.name = _geom_name(item)
    geom.rgba = item.rgba
    geom.condim = _condim(item)
    geom.friction = [item.friction, SPINNING, OBJECT_ROLLING]
    geom.solref = OBJECT_SOLREF
    geom.priority = 1
    if isinstance(item.geometry, Mesh):  # as solid as what touches; never refused
        mesh = spec.mesh(geom.meshname)
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    if item.mass is not None:
        geom.mass = item.mass
        body.add_freejoint(name=free_joint_name(item.name))


def _add_pair(spec: Any, first: str, second: str, mu: float) -> Any:
    return spec.add_pair(
        geomname1=first,
        geomname2=second,
        friction=[mu, mu, SPINNING, OBJECT_ROLLING, OBJECT_ROLLING],
    )


def _condim(item: SceneObject) -> int:
    return _ROUND if isinstance(item.geometry, Cylinder | Sphere) else _PATCH


def _geom_name(item: SceneObject) -> str:
    return f"{item.name}/object"
