"""Selection of the arm or gripper for a request that does not specify one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from tool0.description.model import RobotModel
from tool0.errors import ControlError

Part = TypeVar("Part")


def only_part(parts: Mapping[str, Part], kind: str, model: RobotModel) -> Part:
    """Return the robot's only part of a ``kind``; otherwise, raise ControlError."""
    if len(parts) == 1:
        return next(iter(parts.values()))
    if kind == "arm" and not parts:
        from tool0.kinematics.chain import why_no_arm

        why = why_no_arm(model)
        raise ControlError(f"this robot has no arm to move to poses: {why}")
    names = ", ".join(parts) or "none"
    raise ControlError(f"'{kind}' needs exactly one {kind}, this robot has: {names}")
