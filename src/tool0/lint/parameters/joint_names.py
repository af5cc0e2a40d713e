"""Names of a robot's joints, and what is wrong when a file names others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

from tool0.description.finding import Finding
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import nearest_name
from tool0.lint.robot.facts import RobotFacts

_ENOUGH = 0.6
"""Share of a list's joints that the usual robot must have to be taken for it."""


@lru_cache(maxsize=1)
def usual_joints() -> frozenset[str]:
    """Return the movable joints of the usual robot, a UR5 with a 2F-85."""
    from tool0.description.catalogue import assemble

    return frozenset(joint.name for joint in assemble().model.movable_joints)


def unknown_joints(
    entries: Sequence[tuple[str, YamlEntry]], robot: RobotFacts | None
) -> Iterator[Finding]:
    """Yield a finding for each joint of one list that the robot lacks.

    Args:
        entries: The names, and where they are written.
        robot: The robot, if it is known.
    """
    names = [name for name, _ in entries]
    if robot is not None:
        known = set(robot.movable_joints)
        reason = "the robot has no such joint"
    else:
        known = set(usual_joints())
        if sum(name in known for name in names) < _ENOUGH * len(names):
            return
        reason = "a UR with a 2F-85, whose joints are beside it, has no such joint"
    for name, entry in entries:
        if name in known:
            continue
        unused = known.difference(names)
        near = nearest_name(name, unused) or nearest_name(name, known)
        yield entry.finding(
            "unknown-joint",
            f"names '{name}', but {reason}",
            f"did you mean '{near}'?" if near else "name one that it has",
            severity="error" if robot is not None else "warning",
        )
