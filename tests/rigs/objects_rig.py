"""Objects and meshes beside the skew robot in MuJoCo, mostly far from it."""

from __future__ import annotations

import struct
from pathlib import Path

from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box, Mesh, Solid
from tool0.description.transform import Pose
from tool0.engines.mujoco.engine import MujocoEngine

REST = [0.0, 0.0, 0.0, 0.2]
"""Position of the skew robot's joints."""
FAR = 5.0  # [m] from the robot, which lies about
EDGE = 0.04  # [m]
TETRAHEDRON = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def item(
    name: str,
    geometry: Solid,
    z: float,
    *,
    x: float = FAR,
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0),
    mass: float | None = 0.1,
    friction: float = 1.0,
) -> SceneObject:
    pose = Pose(xyz=(x, 0.0, z), rpy=rpy)
    return SceneObject(
        name=name, geometry=geometry, pose=pose, mass=mass, friction=friction
    )


def cube(
    name: str = "cube",
    x: float = FAR,
    z: float = EDGE / 2,
    *,
    mass: float | None = 0.1,
    friction: float = 1.0,
) -> SceneObject:
    box = Box(size=(EDGE, EDGE, EDGE))
    return item(name, box, z, x=x, mass=mass, friction=friction)


def engine_with(
    model: RobotModel, *objects: SceneObject, ground: float | None = 0.0
) -> MujocoEngine:
    engine = MujocoEngine(model, ground=ground, scene=Scene(objects))
    engine.reset(REST)
    return engine


def run(engine: MujocoEngine, duration: float) -> None:
    """Step for ``duration`` [s], and raise if anything diverges."""
    for _ in range(round(duration / engine.dt)):
        engine.step()
        engine.read()


def state_of(engine: MujocoEngine, name: str) -> ObjectState:
    (found,) = [each for each in engine.world.object_states() if each.name == name]
    return found


def tetrahedron(path: Path) -> Mesh:
    """Write a tetrahedron with legs of 1 m, and return it at a tenth of that."""
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(c for i in face for c in TETRAHEDRON[i]), 0)
        for face in FACES
    )
    path.write_bytes(bytes(80) + struct.pack("<I", len(FACES)) + facets)
    return Mesh(uri=path.name, path=path, scale=(0.1, 0.1, 0.1))
