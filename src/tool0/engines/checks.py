"""Checks that every engine makes on what it is asked to do."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tool0.description.scene import SceneObject
from tool0.errors import ConfigError, DivergenceError, EngineError, did_you_mean
from tool0.hardware.engine import ObjectState


def check_dt(dt: float) -> None:
    """Raise ConfigError unless ``dt`` [s] can be the length of a step."""
    if not 0.0 < dt < math.inf:
        raise ConfigError(f"the step must be above 0 s and finite, got {dt}")


def effort_divergence(
    joint_names: Sequence[str], effort: Sequence[float], time: float
) -> DivergenceError:
    """Return the error for efforts [N·m | N] whose sum is not finite."""
    worst = next((i for i, u in enumerate(effort) if not math.isfinite(u)), 0)
    return DivergenceError(joint_names[worst], time, "effort")


def check_new_name(objects: Mapping[str, SceneObject], name: str) -> None:
    """Raise EngineError if there is an object ``name`` already."""
    if name in objects:
        raise EngineError(
            f"there is an object '{name}' already; "
            "remove it first, or take another name"
        )


def find_object(objects: Mapping[str, SceneObject], name: str) -> SceneObject:
    """Return the object ``name``, or raise EngineError if there is none."""
    if name not in objects:
        hint = did_you_mean(name, set(objects))
        raise EngineError(f"there is no object '{name}'{hint}")
    return objects[name]


def check_attachable(objects: Mapping[str, SceneObject], name: str) -> None:
    """Raise EngineError unless there is an object ``name`` that can move."""
    if find_object(objects, name).mass is None:
        raise EngineError(
            f"object '{name}' has no mass and is static; only a movable object can be "
            "attached"
        )


def check_placement(objects: Mapping[str, SceneObject], state: ObjectState) -> None:
    """Raise EngineError unless the object of ``state`` can have that velocity."""
    item = find_object(objects, state.name)
    if item.mass is None and any((*state.linear, *state.angular)):
        raise EngineError(
            f"object '{state.name}' has no mass and is static; "
            "place it without a velocity"
        )
