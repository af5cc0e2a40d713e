"""Parts of the built-in controllers: files of the catalogue, and names in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.description.catalogue import CataloguePart, PartKind, shared_folder
from tool0.description.model import RobotModel
from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.description.yaml_tree import read_verbatim
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation

if TYPE_CHECKING:
    from tool0.control.gains import DerivedGains

LIMITS: Final = "joint_limits"
"""Key of limits in a YAML that replace the URDF's."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Gains or limits of one joint: a line of YAML."""

    joint: str
    values: str
    comment: str
    location: SourceLocation


def limits_row(description: RobotDescription, joint: str, derived: DerivedGains) -> Row:
    """Return the acceleration and jerk that planned motions of a joint keep to."""
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
    """Return the prefix of the controllers of a robot: ``left_`` for ``left``."""
    return f"{robot.name}_" if robot.name else ""


def renamed(
    description: RobotDescription, robot: CatalogueRobot | None, text: str
) -> str:
    """Return YAML ``text`` with prefixes before joints and controllers."""
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


def read_part(path: Path) -> str:
    """Return the text of a file of controllers."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(
            f"cannot read the controllers: {error}", SourceLocation(path)
        ) from None


def part_file(kind: PartKind, part: CataloguePart | None, name: str) -> Path:
    """Return a file of a part's folder, or the one that all of its kind share."""
    return shared_folder(kind) / name if part is None else part.file(name)


def joints_beyond(model: RobotModel, joint: str) -> list[str]:
    """Return the driven joints beyond an arm's last ``joint``."""
    links = set(model.links_from(model.joint(joint).child))
    return [
        item.name
        for item in model.movable_joints
        if item.parent in links and item.name in model.transmission_by_joint
    ]


def rating(part: CataloguePart, name: str) -> float | None:
    """Return a rating of a part, such as its payload [kg]; None if it has none."""
    path = part.file("specifications.yaml")
    if not path.is_file():
        return None
    entries = Namespace(read_verbatim(path).root).namespace("specifications")
    if entries is None or entries.find(name) is None:
        return None
    return entries.not_negative(name)


def number_text(value: float) -> str:
    """Return a number without exponent, which YAML 1.1 could take for a text."""
    if not math.isfinite(value):
        return f"{'-' if value < 0 else ''}.inf" if math.isinf(value) else ".nan"
    whole = int(value)
    return str(whole) if whole == value else format(Decimal(repr(value)), "f")
