"""A robot as text for people: its tree of links, and its joints as a table."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tool0.description.model import Joint, JointType, RobotModel


def tree_text(model: RobotModel) -> str:
    """Return the links and joints as an indented tree, one joint and its link a line.

    Joints that do not move are marked ``fixed``, joints that follow another one say
    which: ``mimics -1 · finger_joint``.
    """
    lines = [model.root, *_branches(model, model.root, "")]
    return "\n".join(lines) + "\n"


def _branches(model: RobotModel, link: str, indent: str) -> Iterator[str]:
    joints = model.child_joints[link]
    for joint in joints:
        is_last = joint is joints[-1]
        corner, below = ("└── ", "    ") if is_last else ("├── ", "│   ")
        yield f"{indent}{corner}{joint.child}  ← {joint.name} ({_kind(joint)})"
        yield from _branches(model, joint.child, indent + below)


def _kind(joint: Joint) -> str:
    if joint.mimic is None:
        return joint.type.value
    return f"{joint.type.value}, mimics {_mimic(joint)}"


def table_text(model: RobotModel) -> str:
    """Return the movable joints with type, axis, limits, mimic and interface."""
    rows = [
        ("joint", "type", "axis", "lower", "upper", "velocity", "effort", "driven by"),
        ("", "", "", "[rad|m]", "[rad|m]", "[/s]", "[N·m|N]", ""),
        *(_row(model, joint) for joint in model.movable_joints),
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    )
    return "".join(f"{line.rstrip()}\n" for line in lines)


def _row(model: RobotModel, joint: Joint) -> tuple[str, ...]:
    limits = joint.limits
    bounds = (limits.lower, limits.upper, limits.velocity, limits.effort)
    has_axis = joint.type not in {JointType.FLOATING, JointType.FIXED}
    return (
        joint.name,
        joint.type.value,
        " ".join(f"{value:g}" for value in joint.axis) if has_axis else "-",
        *(f"{value:.5g}" if math.isfinite(value) else "-" for value in bounds),
        _drive(model, joint),
    )


def _drive(model: RobotModel, joint: Joint) -> str:
    if joint.mimic is not None:
        return f"mimics {_mimic(joint)}"
    transmission = model.transmission_by_joint.get(joint.name)
    return "-" if transmission is None else transmission.interface.value


def _mimic(joint: Joint) -> str:
    if joint.mimic is None:
        return ""
    offset = f" {joint.mimic.offset:+g}" if joint.mimic.offset else ""
    return f"{joint.mimic.multiplier:g} · {joint.mimic.joint}{offset}"
