"""Joint limits in YAML, which override the limits of the URDF."""

from __future__ import annotations

import math
from functools import cache

from tool0.description.yaml_tree import Tree
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation

_SAMPLE_LIMITS = """
{has_position_limits: true, min_position: 0, max_position: 0,
 has_velocity_limits: true, max_velocity: 1, has_effort_limits: true, max_effort: 1,
 has_acceleration_limits: true, max_acceleration: 1,
 has_jerk_limits: true, max_jerk: 1}
"""
"""Limits of a sample joint, with every parameter, for ``joint_limit_parameters``."""


@cache
def joint_limit_parameters() -> frozenset[str]:
    """Return the parameters that are allowed under ``joint_limits/<joint>``."""
    tree = Tree()
    tree.load(_SAMPLE_LIMITS, SourceLocation(None, 1))
    sample = Namespace(tree.root)
    read_joint_limits(sample)
    return sample.read_keys()


def read_joint_limits(limits: Namespace) -> dict[str, float]:
    """Read the limits of one joint.

    As in ROS, a limit applies only if the parameter ``has_…_limits`` is true.
    """
    limits.accept("angle_wraparound")

    def has_limit(kind: str) -> bool | None:
        flag = f"has_{kind}_limits"
        return None if limits.find(flag) is None else limits.boolean(flag, default=True)

    found: dict[str, float] = {}
    if has_limit("position") is False:
        found = {"lower": -math.inf, "upper": math.inf}
    elif has_limit("position"):
        lower, upper = limits.number("min_position"), limits.number("max_position")
        if not lower <= upper:
            raise ConfigError(
                f"'{limits.entry.key}' has min_position {lower} "
                f"above max_position {upper}",
                limits.location,
            )
        found = {"lower": lower, "upper": upper}
    for kind in ("velocity", "acceleration", "jerk", "effort"):
        has = has_limit(kind)
        if has is not None:
            found[kind] = limits.not_negative(f"max_{kind}") if has else math.inf
    return found
