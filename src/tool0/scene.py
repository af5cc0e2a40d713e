"""The surroundings of a robot: scenes, and their objects, cameras, shapes and poses.

Use these classes with ``robot.scene`` and ``tool0.bringup(scene=…)``::

    from tool0.scene import Box

    robot.scene.add("cube", Box(size=(0.04, 0.04, 0.04)), xyz=(0.5, 0, 0.3), mass=0.1)
"""

from __future__ import annotations

from tool0.description.camera import Camera, looking
from tool0.description.scene import Scene, SceneObject, bin_walls
from tool0.description.scene_file import load_scene, shipped_scenes
from tool0.description.shapes import Box, Compound, Cylinder, Mesh, Sphere, mesh
from tool0.description.transform import Pose

__all__ = [
    "Box",
    "Camera",
    "Compound",
    "Cylinder",
    "Mesh",
    "Pose",
    "Scene",
    "SceneObject",
    "Sphere",
    "bin_walls",
    "load_scene",
    "looking",
    "mesh",
    "shipped_scenes",
]
