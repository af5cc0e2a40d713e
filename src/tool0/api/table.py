"""A table for picks, scaled to the reach of an arm."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

from tool0.description.grasp_frames import grasp_frame
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_file import load_scene
from tool0.description.shapes import Box
from tool0.description.transform import Pose, to_transform
from tool0.errors import ModelError

if TYPE_CHECKING:
    from tool0.api.robot import Robot
    from tool0.description.model import RobotModel

ITEM, BIN, TABLE = "cube", "bin", "table"
"""Names of the object, the bin and the table in the scene ``table_and_bin``."""
TABLE_TOP = -0.02
"""Height of the table in the scene ``table_and_bin``, in the robot's root frame [m]."""
ARM_LENGTH = 0.81725
"""Total length of the upper arm and the forearm for which ``table_and_bin`` is designed
[m]."""
LIFT = 0.15
"""Value of ``lift`` for an arm of ``ARM_LENGTH`` [m]."""
LOWEST_LIFT = 0.1
"""Minimum value of ``lift`` for short arms [m]; the walls of the bin are 0.08 m
high."""
NEAR, FAR = 0.40, 0.65
"""Range of the x coordinate of random poses on the table [m]."""
RIGHT, LEFT = -0.10, 0.30
"""Range of the y coordinate of random poses on the table [m]."""
BIN_Y, BIN_HALF_WIDTH = -0.32, 0.10
"""The y coordinate of the bin's center, and half of the bin's width [m]."""
GAP = 0.12
"""Minimum distance that a gripper needs between an object's center and the bin [m]."""
ATTEMPTS = 1000


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickTable:
    """A table with an object and a bin in front of an arm, like ``table_and_bin``."""

    scale: float
    """Scale of the distances on the table; the sizes of the object and the bin do not
    change."""
    base: tuple[float, float] = (0.0, 0.0)
    """Position of the arm's base in the root frame, x and y [m]."""
    arm: str | None = None
    """Name of the arm and its gripper; None selects the robot's only arm and
    gripper."""
    is_turned: bool = False
    """Whether the arm faces the -x direction of the root frame; the table is then
    rotated by pi."""

    @property
    def lift(self) -> float:
        """Height at which the object is carried [m]."""
        return min(LIFT, max(LOWEST_LIFT, LIFT * self.scale))

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Transform a position in ``table_and_bin`` to the root frame [m]."""
        scale = -self.scale if self.is_turned else self.scale
        return self.base[0] + x * scale, self.base[1] + y * scale

    def scene(self, *, edge: float, mass: float, friction: float) -> Scene:
        """Return the scene with a cube of ``edge`` [m] and ``mass`` [kg]."""
        shipped = load_scene("table_and_bin")
        floor = next(i for i in shipped.objects if i.name == f"{BIN}.floor")
        x_bin, y_bin = floor.pose.xyz[:2]
        objects = []
        for item in shipped.objects:
            x, y, z = item.pose.xyz
            new_x, new_y = self.at(x, y)
            geometry = item.geometry
            if item.name.startswith(f"{BIN}."):
                moved_x, moved_y = self.at(x_bin, y_bin)
                new_x, new_y = moved_x + (x - x_bin), moved_y + (y - y_bin)
            elif item.name == TABLE and isinstance(geometry, Box):
                dx, dy, dz = geometry.size
                geometry = Box(size=(dx * self.scale, dy * self.scale, dz))
            changed = replace(
                item,
                geometry=geometry,
                pose=replace(item.pose, xyz=(new_x, new_y, z)),
            )
            if item.name == ITEM:
                changed = replace(
                    changed,
                    geometry=Box(size=(edge, edge, edge)),
                    pose=Pose(xyz=(new_x, new_y, TABLE_TOP + edge / 2.0)),
                    mass=mass,
                    friction=friction,
                )
            objects.append(changed)
        return replace(shipped, objects=tuple(objects))

    def random_poses(self, robot: Robot, height: float, seed: int) -> Iterator[Pose]:
        """Yield an endless sequence of random poses of an object on the table.

        The poses are in the robot's root frame.  The poses are sufficiently far from
        the bin.  At each pose, the arm can grip the object from above and lift it.

        Args:
            robot: The robot that will lift the object.
            height: Height of the upright object [m].
            seed: Seed of the poses; the same seed gives the same poses.
        """
        rng = random.Random(seed)
        # The size of the bin is constant, so the bin covers a larger part of a small
        # table.
        right = max(RIGHT, BIN_Y + (BIN_HALF_WIDTH + GAP) / self.scale)
        while True:
            for _ in range(ATTEMPTS):
                x, y = self.at(rng.uniform(NEAR, FAR), rng.uniform(right, LEFT))
                yaw = rng.uniform(-math.pi, math.pi)
                xyz = (x, y, TABLE_TOP + height / 2.0)
                pose = Pose(xyz=xyz, rpy=(0.0, 0.0, yaw))
                if self._is_in_reach(robot, pose):
                    break
            yield pose

    def _is_in_reach(self, robot: Robot, pose: Pose) -> bool:
        """Return whether the arm can grip an object from above and lift it."""
        arm = robot.arm if self.arm is None else robot.arms[self.arm]
        gripper = robot.gripper if self.arm is None else robot.grippers[self.arm]
        geometry = gripper.geometry
        tool = grasp_frame(
            robot.description.model, geometry, geometry.max_opening / 2.0, arm.tip
        )
        x, y, z = pose.xyz
        rpy = (math.pi, 0.0, pose.rpy[2])
        try:
            for height in (z, z + self.lift):
                grasp = to_transform(Pose(xyz=(x, y, height), rpy=rpy))
                arm.inverse_kinematics(grasp, tool=tool)
        except ModelError:
            return False
        return True


def joined(tables: Iterable[SceneObject]) -> SceneObject:
    """Return a table that covers several tables, all aligned with the root's axes."""
    first, *_ = boxes = [item for item in tables if isinstance(item.geometry, Box)]
    low, high = (
        [
            bound(
                item.pose.xyz[k] + side * item.geometry.size[k] / 2.0
                for item in boxes
                if isinstance(item.geometry, Box)
            )
            for k in range(3)
        ]
        for bound, side in ((min, -1.0), (max, 1.0))
    )
    x, y, z = ((a + b) / 2.0 for a, b in zip(low, high, strict=True))
    dx, dy, dz = (b - a for a, b in zip(low, high, strict=True))
    return replace(first, geometry=Box(size=(dx, dy, dz)), pose=Pose(xyz=(x, y, z)))


def arm_scale(model: RobotModel) -> float:
    """Return the length of a robot's only arm, as a multiple of ``ARM_LENGTH``.

    Raises:
        ControlError: If the robot does not have exactly one arm, or if the arm does not
            have the kinematics of a UR.
    """
    from tool0.kinematics.chain import find_chains
    from tool0.kinematics.geometry import ArmGeometry
    from tool0.kinematics.only_part import only_part

    arm = ArmGeometry(only_part(find_chains(model), "arm", model))
    return round((arm.upper_arm + arm.forearm) / ARM_LENGTH, 2)
