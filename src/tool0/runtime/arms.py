"""The arms of a robot, by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tool0.errors import ControlError
from tool0.kinematics.chain import find_chains, why_no_arm
from tool0.runtime.arm import Arm

if TYPE_CHECKING:
    from tool0.runtime.robot import Robot


def find_arms(robot: Robot) -> Mapping[str, Arm]:
    """Return the robot's arms by name."""
    chains = find_chains(robot.description.model)
    return {name: Arm(name, chain, robot) for name, chain in chains.items()}


def the_arm(robot: Robot, arms: Mapping[str, Arm]) -> Arm:
    """Return the robot's arm, or raise ControlError if it has not exactly one."""
    if len(arms) == 1:
        return next(iter(arms.values()))
    if arms:
        raise ControlError(
            f"'arm' needs exactly one arm, this robot has: {', '.join(arms)}; "
            "use arms[name]"
        )
    why = why_no_arm(robot.description.model)
    raise ControlError(f"this robot has no arm that poses could be given to: {why}")
