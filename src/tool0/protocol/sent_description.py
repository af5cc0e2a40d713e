"""A robot's description in the form that backends send."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from tool0.description.loading import load_description
from tool0.description.packages import BUNDLED
from tool0.description.robot import RobotDescription
from tool0.protocol.robot import CatalogueRobotInfo, DescriptionInfo, NamespaceInfo

if TYPE_CHECKING:
    pass


def description_info(description: RobotDescription, spawn_z: float) -> DescriptionInfo:
    """Return the sent form of a description.

    Args:
        description: Description of the robot.
        spawn_z: Height of the robot's root above the world's origin [m].
    """
    return DescriptionInfo(
        urdf=description.urdf,
        source=str(description.source),
        robots=tuple(
            CatalogueRobotInfo(
                name=robot.name,
                arm=str(robot.arm.folder),
                gripper=None if robot.gripper is None else str(robot.gripper.folder),
                prefix=robot.prefix,
            )
            for robot in description.robots
        ),
        namespaces=tuple(_namespaces(description, spawn_z)),
        packages={
            folder.name: folder.as_uri()
            for folder in BUNDLED.iterdir()
            if (folder / "package.xml").is_file()
        },
    )


def _namespaces(
    description: RobotDescription, spawn_z: float
) -> Iterator[NamespaceInfo]:
    cell = description.cell
    for robot in cell.robots if cell is not None and cell.namespaces else ():
        alone = load_description(robot.description, spawn_z=spawn_z)
        yield NamespaceInfo(name=robot.name, urdf=alone.urdf)
