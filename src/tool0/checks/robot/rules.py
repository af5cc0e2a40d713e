"""All the rules for one robot, and for one xacro file as it is written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from tool0.description.finding import Finding
from tool0.description.xml_source import LocatedElement

_NONE: Mapping[str, Path] = {}


def robot_findings(
    root: LocatedElement, packages: Mapping[str, Path] = _NONE, *, spawned: bool = False
) -> Iterator[Finding]:
    """Yield what is wrong in a <robot> of URDF, or of expanded xacro.

    Args:
        root: The <robot>.
        packages: Folders of packages by name, which are found before any other.
        spawned: Whether it is known to be put into Gazebo to be controlled there.
    """
    yield from ()


def xacro_findings(
    root: LocatedElement, packages: Mapping[str, Path] = _NONE
) -> Iterator[Finding]:
    """Yield what is wrong in a xacro file as it is written, before any expansion."""
    yield from ()
