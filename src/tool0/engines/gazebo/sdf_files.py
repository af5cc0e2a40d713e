"""World and model files: our empty world, and checks of a person's own files."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from tool0.errors import DescriptionError, SourceLocation

EMPTY_WORLD = Path(__file__).with_name("empty.world")
"""A world with a sun, and the ground at z = 0."""


def check_world(file: Path) -> None:
    """Raise DescriptionError unless ``file`` is an SDF with a world in it."""
    root = _root(file, "world")
    if root.tag != "sdf" or root.find("world") is None:
        raise DescriptionError(
            f"<{root.tag}> is no world; a world is <sdf><world>…</world></sdf>",
            SourceLocation(file, 1),
        )


def check_model(file: Path) -> None:
    """Raise DescriptionError unless ``file`` is a URDF or an SDF with a model."""
    root = _root(file, "model")
    if root.tag != "robot" and (root.tag != "sdf" or root.find("model") is None):
        raise DescriptionError(
            f"<{root.tag}> is no model; a model is <sdf><model>…</model></sdf>, "
            "or a URDF's <robot>",
            SourceLocation(file, 1),
        )


def _root(file: Path, what: str) -> ET.Element:
    try:
        return ET.parse(file).getroot()
    except OSError as error:
        raise DescriptionError(
            f"cannot read the {what} {file}: {error.strerror}"
        ) from None
    except ET.ParseError as error:
        line = error.position[0]
        raise DescriptionError(f"no XML: {error}", SourceLocation(file, line)) from None
