"""Parts of the built-in controllers: catalogue files, and the names in these files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.description import arm_files
from tool0.description.catalogue import CataloguePart, PartKind, shared_folder
from tool0.description.model import FLANGE, Interface, RobotModel
from tool0.description.parts import find_arms
from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.description.yaml_tree import read_verbatim
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation

if TYPE_CHECKING:
    from tool0.control.gains import DerivedGains

CATALOGUE_JOINTS: Final = tuple(arm_files.JOINTS.values())
"""Names of the joints in the files that all arms share."""
LIMITS: Final = "joint_limits"
"""Key of a YAML file for limits that override the limits of the URDF."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Gains or limits of one joint, as a line of YAML."""

    joint: str
    values: str
    comment: str
    location: SourceLocation


def limits_row(description: RobotDescription, joint: str, derived: DerivedGains) -> Row:
    """Return the row with the acceleration and jerk limits for planned motions."""
    values = (
        f"has_acceleration_limits: true, "
        f"max_acceleration: {number_text(derived.acceleration)}, "
        f"has_jerk_limits: true, max_jerk: {number_text(derived.jerk)}"
    )
    return Row(
        joint=joint,
        values=f"{{{values}}}",
        comment=derived.limits_derivation,
        location=SourceLocation(description.source),
    )


def lines_of(rows: Sequence[Row], indent: str) -> str:
    """Return the rows as lines of YAML."""
    return "".join(
        f"{indent}{row.joint}: {row.values}  # {row.comment}\n" for row in rows
    )


def controller_prefix(robot: CatalogueRobot) -> str:
    """Return the prefix of a robot's controllers, such as ``left_`` for ``left``."""
    return f"{robot.name}_" if robot.name else ""


def renamed(
    description: RobotDescription, robot: CatalogueRobot | None, text: str
) -> str:
    """Return YAML ``text`` with prefixes for the robot's joints and controllers."""
    if robot is None or not (robot.prefix or robot.name):
        return text
    import yaml

    joints = {
        transmission.joint.removeprefix(robot.prefix)
        for transmission in description.model.transmissions
        if transmission.joint.startswith(robot.prefix)
    }
    for token in reversed(list(yaml.scan(text, yaml.SafeLoader))):
        if not isinstance(token, yaml.ScalarToken):
            continue
        start = token.start_mark.index + (token.style is not None)
        if token.value in joints:
            text = text[:start] + robot.prefix + text[start:]
        elif token.start_mark.column == 0:
            text = text[:start] + controller_prefix(robot) + text[start:]
    return text


@final
@dataclass(frozen=True, slots=True)
class OwnArm:
    """An arm in a robot file of the user."""

    prefix: str
    """Prefix of the arm's controllers; empty if the robot has only one arm."""
    names: str
    """Prefix of the arm's links and of its hardware interfaces."""
    joints: tuple[str, ...]
    """Joints of the arm, from the base to the flange."""

    def written(self, text: str) -> str:
        """Return YAML ``text`` with the joints of this arm, not of the catalogue arm.

        A line that contains the first joint of the catalogue arm is repeated for each
        joint.  ``$prefix`` is replaced with the prefix of the arm's links.
        """
        first, *others = CATALOGUE_JOINTS
        lines = []
        for line in text.splitlines(keepends=True):
            if first in line:
                lines += [line.replace(first, joint) for joint in self.joints]
            elif not any(joint in line for joint in others):
                is_name = line[:1].isalpha() and line.rstrip().endswith(":")
                lines.append(self.prefix + line if is_name else line)
        return "".join(lines).replace("$prefix", self.names)


def own_arms(model: RobotModel) -> tuple[OwnArm, ...]:
    """Return the arms of a robot that is not from the catalogue.

    A kinematic chain is an arm if it ends at a link ``…tool0``, or if it has the joints
    of a catalogue arm.
    """
    arms = find_arms(model)
    if not arms and set(CATALOGUE_JOINTS) <= model.joint_by_name.keys():
        return (OwnArm("", "", CATALOGUE_JOINTS),)
    return tuple(
        OwnArm(
            f"{name}_" if len(arms) > 1 else "",
            arm.flange.removesuffix(FLANGE),
            tuple(joint.name for joint in arm.joints),
        )
        for name, arm in arms.items()
    )


def common_interface(
    model: RobotModel, joints: Iterable[str], preferred: Sequence[Interface]
) -> Interface | None:
    """Return the first interface of ``preferred`` that all joints have, or None."""
    drives = [model.transmission_by_joint.get(joint) for joint in joints]
    return next(
        (
            kind
            for kind in preferred
            if all(drive and kind in drive.interfaces for drive in drives)
        ),
        None,
    )


def read_part(path: Path) -> str:
    """Return the text of a file that defines controllers."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(
            f"cannot read the controllers: {error}", SourceLocation(path)
        ) from None


def part_file(kind: PartKind, part: CataloguePart | None, name: str) -> Path:
    """Return a file from a part's folder, or the shared file for the kind of part."""
    return shared_folder(kind) / name if part is None else part.file(name)


def joints_beyond(model: RobotModel, joint: str) -> list[str]:
    """Return the driven joints beyond ``joint``, which is the last joint of an arm."""
    links = set(model.links_from(model.joint(joint).child))
    return [
        item.name
        for item in model.movable_joints
        if item.parent in links and item.name in model.transmission_by_joint
    ]


def rating(part: CataloguePart, name: str) -> float | None:
    """Return a rating of a part, such as its payload [kg], or None if unspecified."""
    path = part.file("specifications.yaml")
    if not path.is_file():
        return None
    entries = Namespace(read_verbatim(path).root).namespace("specifications")
    if entries is None or entries.find(name) is None:
        return None
    return entries.not_negative(name)


def number_text(value: float) -> str:
    """Return a number without an exponent.

    A YAML 1.1 parser could read a number with an exponent as a string.
    """
    if not math.isfinite(value):
        return f"{'-' if value < 0 else ''}.inf" if math.isinf(value) else ".nan"
    whole = int(value)
    return str(whole) if whole == value else format(Decimal(repr(value)), "f")
