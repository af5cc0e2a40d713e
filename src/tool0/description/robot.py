"""A robot as it is described: its model, its URDF, and where it is from."""

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
    """An arm of the catalogue with its gripper."""

    name: str = ""
    """Name of the robot in a cell, such as ``left``; empty for a single robot."""
    arm: CataloguePart
    gripper: CataloguePart | None = None
    prefix: str = ""
    """Prefix of the names of its links and joints."""

    @property
    def parts(self) -> tuple[CataloguePart, ...]:
        return (self.arm,) if self.gripper is None else (self.arm, self.gripper)

    @property
    def parts_title(self) -> str:
        """Such as ``ur5 + 2f85``."""
        return " + ".join(part.name for part in self.parts)

    @property
    def title(self) -> str:
        """Such as ``ur5 + 2f85``, in a cell ``left: ur5 + 2f85``."""
        return f"{self.name}: {self.parts_title}" if self.name else self.parts_title


@final
@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """A robot: the model for the engines, and the URDF for everything else."""

    model: RobotModel
    """Links, joints, drives and grippers, checked."""
    source: Path
    """The xacro or URDF file that it was read from."""
    robots: tuple[CatalogueRobot, ...] = ()
    """Arms and grippers of the catalogue; none for your own file."""
    disabled_collisions: frozenset[frozenset[str]] = frozenset()
    """Pairs of links that planned motions need not keep apart, of an SRDF."""
    cell: Cell | None = None
    """The cell of its ``robots``; None for a single one, or in another process."""
    tf_prefix: str = ""
    """Prefix of its frames in ROS."""
    arguments: Mapping[str, str] = field(default_factory=dict)
    """The values of the arguments of its xacro file; none in a cell, or in another
    process."""
    _document: Document = field(repr=False, compare=False)

    @cached_property
    def urdf(self) -> str:
        """The whole robot as one URDF document, without xacro."""
        return to_text(self._document)

    @property
    def title(self) -> str:
        """Title shown to users: the names of its parts, or that of your own file."""
        return ", ".join(robot.title for robot in self.robots) or self.source.name

    @property
    def prefix(self) -> str:
        """Prefix of all names, for one robot of the catalogue; otherwise empty."""
        return self.robots[0].prefix if len(self.robots) == 1 else ""
