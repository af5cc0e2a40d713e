"""Pairs of links, from an SRDF, between which motions ignore collisions."""

from __future__ import annotations

from pathlib import Path

from tool0.description.model import RobotModel
from tool0.description.xml_source import children, locate, parse_file, required
from tool0.errors import DescriptionError, did_you_mean


def read_disabled_collisions(
    file: Path, model: RobotModel
) -> frozenset[frozenset[str]]:
    """Return the pairs of links in ``<disable_collisions>``.

    All other elements, such as groups and states, are ignored.

    Raises:
        DescriptionError: If the file is not an SRDF, or contains a link that the robot
            does not have.  The error states the file and the line.
    """
    root = parse_file(file).documentElement
    if root is None or root.tagName != "robot":
        raise DescriptionError(f"'{file}' is no SRDF: it has no <robot>", locate(root))
    pairs = set()
    for element in children(root, "disable_collisions"):
        names = [required(element, attribute) for attribute in ("link1", "link2")]
        for name in names:
            if name not in model.link_by_name:
                hint = did_you_mean(name, set(model.link_by_name))
                raise DescriptionError(
                    f"<disable_collisions>: the robot has no link '{name}'{hint}",
                    locate(element),
                )
        pairs.add(frozenset(names))
    return frozenset(pairs)
