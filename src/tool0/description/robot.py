"""A robot's description: the robot's model, URDF and source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, final

from tool0.description.catalogue import CataloguePart
from tool0.description.model import RobotModel
from tool0.description.xml_source import to_text

if TYPE_CHECKING:
    from xml.dom.minidom import Document

    from tool0.description.config import Cell


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CatalogueRobot:
    """An arm from the catalogue with its gripper."""

    name: str = ""
    """Name of the robot in a cell, such as ``left``; empty for a single robot."""
    arm: CataloguePart
    gripper: CataloguePart | None = None
    prefix: str = ""
    """Prefix of the names of the robot's links and joints."""

    @property
    def parts(self) -> tuple[CataloguePart, ...]:
        return (self.arm,) if self.gripper is None else (self.arm, self.gripper)

    @property
    def parts_title(self) -> str:
        """Names of the arm and the gripper, such as ``ur5 + 2f85``."""
        return " + ".join(part.name for part in self.parts)

    @property
    def title(self) -> str:
        """Title of the robot: ``ur5 + 2f85``, or ``left: ur5 + 2f85`` in a cell."""
        return f"{self.name}: {self.parts_title}" if self.name else self.parts_title


@final
@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """Description of a robot: the model for engines, and the URDF for other uses."""

    model: RobotModel
    """Validated model with links, joints, drives and grippers."""
    source: Path
    """Xacro or URDF file from which the robot was read."""
    robots: tuple[CatalogueRobot, ...] = ()
    """Arms and grippers from the catalogue; empty for your own file."""
    disabled_collisions: frozenset[frozenset[str]] = frozenset()
    """Pairs of links, from an SRDF, between which planned motions ignore collisions."""
    cell: Cell | None = None
    """Cell that contains ``robots``.  The value is None for a single robot, and in
    processes that receive the description from another process."""
    tf_prefix: str = ""
    """Prefix of the robot's frames in ROS."""
    arguments: Mapping[str, str] = field(default_factory=dict)
    """Values of the xacro file's arguments.  The mapping is empty for a cell, and in
    processes that receive the description from another process."""
    _document: Document = field(repr=False, compare=False)

    @cached_property
    def urdf(self) -> str:
        """The whole robot as one URDF document, without xacro."""
        return to_text(self._document)

    @property
    def title(self) -> str:
        """Title for users: the names of the parts, or the name of your own file."""
        return ", ".join(robot.title for robot in self.robots) or self.source.name

    @property
    def prefix(self) -> str:
        """Prefix of all names; empty unless the robot is one catalogue robot."""
        return self.robots[0].prefix if len(self.robots) == 1 else ""
