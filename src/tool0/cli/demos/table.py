"""The table of the picks, as large as an arm needs it."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

from tool0.description.scene import Scene
from tool0.description.scene_file import load_scene
from tool0.description.shapes import Box
from tool0.description.transform import Pose, Transform, to_transform
from tool0.errors import ModelError
from tool0.sensing.grasp import grasp_frame

if TYPE_CHECKING:
    from tool0.api.robot import Robot
    from tool0.description.model import RobotModel

ITEM, BIN, TABLE = "cube", "bin", "table"
"""Their names in the scene ``table_and_bin``."""
TABLE_TOP = -0.02
"""Of that scene, in the robot's root [m]."""
ARM_LENGTH = 0.81725
"""Upper arm and forearm of the arm for which that scene is laid out [m]."""
LIFT = 0.15
"""Height at which that arm carries an object above where it picks and places it [m]."""
LOWEST_LIFT = 0.1
"""The same for a shorter arm: the walls of the bin are 0.08 m high [m]."""
NEAR, FAR = 0.40, 0.65
"""Range of x of random poses on that table [m]."""
RIGHT, LEFT = -0.10, 0.30
"""Range of y [m]: clear of the bin."""
ATTEMPTS = 1000


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickTable:
    """A table with an object and a bin in front of an arm, enlarged by ``scale``."""

    scale: float
    """Of the distances on the table; the object and the bin keep their size."""

    @property
    def lift(self) -> float:
        """Height at which the object is carried [m]."""
        return min(LIFT, max(LOWEST_LIFT, LIFT * self.scale))

    def scene(self, *, edge: float, mass: float, friction: float) -> Scene:
        """Return the scene with a cube of ``edge`` [m] and ``mass`` [kg]."""
        shipped = load_scene("table_and_bin")
        objects = []
        x, y, _ = next(i.pose.xyz for i in shipped.objects if i.name == f"{BIN}.floor")
        shift = (self.scale - 1.0) * x, (self.scale - 1.0) * y
        for item in shipped.objects:
            if item.name.startswith(f"{BIN}."):
                changed = replace(item, pose=_moved(item.pose, *shift))
            else:
                x, y, z = item.pose.xyz
                pose = replace(item.pose, xyz=(x * self.scale, y * self.scale, z))
                changed = replace(item, pose=pose)
            if item.name == TABLE and isinstance(item.geometry, Box):
                x, y, z = item.geometry.size
                size = (x * self.scale, y * self.scale, z)
                changed = replace(changed, geometry=Box(size=size))
            if item.name == ITEM:
                x, y, _ = changed.pose.xyz
                changed = replace(
                    changed,
                    geometry=Box(size=(edge, edge, edge)),
                    pose=Pose(xyz=(x, y, TABLE_TOP + edge / 2.0)),
                    mass=mass,
                    friction=friction,
                )
            objects.append(changed)
        return replace(shipped, objects=tuple(objects))

    def random_poses(self, robot: Robot, height: float, seed: int) -> Iterator[Pose]:
        """Yield poses of an object on the table without end.

        They are clear of the bin, and where the arm can lift the object from above, in
        the robot's root.

        Args:
            robot: With one arm and one gripper.
            height: Of the object, which stands [m].
            seed: The same one yields the same poses.
        """
        rng = random.Random(seed)
        while True:
            for _ in range(ATTEMPTS):
                x, y = rng.uniform(NEAR, FAR), rng.uniform(RIGHT, LEFT)
                yaw = rng.uniform(-math.pi, math.pi)
                xyz = (x * self.scale, y * self.scale, TABLE_TOP + height / 2.0)
                pose = Pose(xyz=xyz, rpy=(0.0, 0.0, yaw))
                if _is_in_reach(robot, pose, self.lift):
                    break
            yield pose


def pick_table(model: RobotModel) -> PickTable:
    """Return the table for the robot's only arm.

    Raises:
        ControlError: Unless the robot has one arm, built like a UR.
    """
    from tool0.kinematics.chain import find_chains
    from tool0.kinematics.geometry import ArmGeometry
    from tool0.runtime.simulation import only_part

    arm = ArmGeometry(only_part(find_chains(model), "arm", model))
    return PickTable(scale=round((arm.upper_arm + arm.forearm) / ARM_LENGTH, 2))


def _moved(pose: Pose, dx: float, dy: float) -> Pose:
    x, y, z = pose.xyz
    return replace(pose, xyz=(x + dx, y + dy, z))


def _is_in_reach(robot: Robot, pose: Pose, lift: float) -> bool:
    """Return whether the arm reaches the object from above, and ``lift`` [m] higher."""
    tool = grasp_frame(
        robot.description.model,
        robot.gripper.geometry,
        robot.gripper.geometry.max_opening / 2.0,
        robot.arm.tip,
    )
    x, y, z = pose.xyz
    yaw = pose.rpy[2]
    try:
        for height in (z, z + lift):
            grasp: Transform = to_transform(
                Pose(xyz=(x, y, height), rpy=(math.pi, 0.0, yaw))
            )
            robot.arm.inverse_kinematics(grasp, tool=tool)
    except ModelError:
        return False
    return True
