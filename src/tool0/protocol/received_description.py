"""A robot's description in the form that clients receive."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tool0.description.catalogue import CataloguePart
from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.description.urdf import read_model
from tool0.protocol.robot import DescriptionInfo

if TYPE_CHECKING:
    from xml.dom.minidom import Document


def described_by(info: DescriptionInfo, document: Document) -> RobotDescription:
    """Return the description of a robot in another process or in a recording.

    Args:
        info: Description as received from the bring-up.
        document: The URDF of the robot, possibly with changed mesh paths.

    Raises:
        ModelError: If the document does not describe a robot.
    """
    robots = tuple(
        CatalogueRobot(
            name=robot.name,
            arm=CataloguePart(kind="arm", folder=Path(robot.arm)),
            gripper=None
            if robot.gripper is None
            else CataloguePart(kind="gripper", folder=Path(robot.gripper)),
            prefix=robot.prefix,
        )
        for robot in info.robots
    )
    return RobotDescription(
        model=read_model(document),
        source=Path(info.source),
        robots=robots,
        _document=document,
    )
