"""The robot of a task: one arm, or two arms that face each other across a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, final

from tool0.api.table import (
    BIN_Y,
    FAR,
    LEFT,
    NEAR,
    PickTable,
    arm_scale,
)
from tool0.description.camera import Camera, default_cameras, looking
from tool0.description.config import Cell, CellRobot, DescriptionConfig
from tool0.description.loading import load_description, named_poses
from tool0.description.parts import find_arms, find_grippers
from tool0.description.transform import Vector3
from tool0.errors import ConfigError, did_you_mean
from tool0.gym.options import EnvOptions

LARGEST_EDGE = 0.045
"""Largest edge of a cube [m]."""
FILL = 0.8
"""Largest edge of a cube, as a fraction of the gripper's largest opening."""
VIEWPOINT: Final = (0.85, -0.65, 0.6)
"""Position of the camera relative to the center of the table, for an arm of scale 1
[m]."""
SIDE_VIEWPOINT: Final = (0.1, -1.5, 0.9)
"""Position of the camera relative to the midpoint between two arms of scale 1 [m]."""


@final
class Site:
    """The identical arms of a task, each with a gripper, and the cameras.

    The root frame is at the base of the first arm, which faces along x.  A second arm
    is mounted opposite the first arm and faces it.
    """

    def __init__(
        self, options: EnvOptions, names: tuple[str, ...], distance: float
    ) -> None:
        """Read the robot's description.

        Args:
            options: Arm, gripper and cameras.
            names: Names of two arms; empty for a single arm.
            distance: Distance between the bases of two arms of scale 1 [m].

        Raises:
            Tool0Error: If the arm or the gripper is unknown or not supported.
        """
        if options.gripper in (None, "none"):
            raise ConfigError("the tasks need a gripper; give one, such as 2f85")
        if len(set(names)) not in {0, 2} or len(names) > 2:
            raise ConfigError(
                "the arms of a task must be two different names, such as "
                f"('left', 'right'), or none for a single arm; got {names!r}"
            )
        self.description = DescriptionConfig(arm=options.arm, gripper=options.gripper)
        robot = load_description(self.description)
        self.scale = arm_scale(robot.model)
        """Size of the arms, relative to a ur5."""
        bases = [(0.0, 0.0), (distance * self.scale, 0.0)]
        if names:
            self.description = _facing(self.description, names, bases)
            robot = load_description(self.description)
        self.model = robot.model
        self.ready = named_poses(robot)["ready"]
        """Positions of all joints in the pose ``ready`` [rad | m]."""
        self.tables = {
            name: PickTable(scale=self.scale, base=base, arm=name, is_turned=k > 0)
            for k, (name, base) in enumerate(
                zip(find_arms(self.model), bases, strict=False)
            )
        }
        """The table in front of each arm, by the arm's name in the robot model."""
        (widest,) = {item.max_opening for item in find_grippers(self.model).values()}
        self.edge = round(min(LARGEST_EDGE, FILL * widest), 4)
        """Edge of each cube [m]."""
        ranges = options.ranges
        self.size_range = (1.0, 1.0) if ranges is None else ranges.size
        """Range of the factor on the size of objects."""
        self.cameras = self._cameras(options)
        """The cameras for images."""

    def _cameras(self, options: EnvOptions) -> tuple[Camera, ...]:
        cameras = {camera.name: camera for camera in default_cameras(self.model)}
        cameras["scene"] = self._overview()
        for name in options.cameras:
            if name not in cameras:
                raise ConfigError(f"no camera '{name}'{did_you_mean(name, cameras)}")
        width, height = options.image_size
        return tuple(
            replace(cameras[name], width=width, height=height)
            for name in options.cameras
        )

    def _overview(self) -> Camera:
        """Return a camera with a view of the tables and the grippers."""
        tables = list(self.tables.values())
        viewpoint: Vector3 = VIEWPOINT
        x, y = tables[0].at((NEAR + FAR) / 2.0, (BIN_Y + LEFT) / 2.0)
        if len(tables) > 1:
            viewpoint, bases = SIDE_VIEWPOINT, [table.base for table in tables]
            x, y = (sum(each) / 2.0 for each in zip(*bases, strict=True))
        at = (x, y, 0.1 * self.scale)
        position = [a + self.scale * b for a, b in zip(at, viewpoint, strict=True)]
        return Camera(name="scene", pose=looking(position, at))


def _facing(
    arm: DescriptionConfig, names: tuple[str, ...], bases: Sequence[tuple[float, float]]
) -> DescriptionConfig:
    """Return a cell of two arms at ``bases`` [m].

    The second arm faces the first arm.
    """
    return DescriptionConfig(
        cell=Cell(
            name="facing",
            robots=tuple(
                CellRobot(
                    name=name,
                    description=replace(
                        arm, base_xyz=(*base, 0.0), base_rpy=(0.0, 0.0, k * math.pi)
                    ),
                )
                for k, (name, base) in enumerate(zip(names, bases, strict=True))
            ),
        )
    )
