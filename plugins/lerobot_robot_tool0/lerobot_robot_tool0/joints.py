"""LeRobot's names of joints: ``elbow_joint.pos`` where tool0 says ``.position``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from tool0.errors import ControlError

_POSITION = ".position"


def named(action_names: Sequence[str], part: str) -> list[str]:
    """Return the names of the joints of an action, with ``pos`` or ``vel``."""
    return [f"{name.removesuffix(_POSITION)}.{part}" for name in action_names]


def values_of(action: Mapping[str, Any], action_names: Sequence[str]) -> list[float]:
    """Return the targets of an action in their order [rad | m].

    Raises:
        ControlError: If one is missing or not finite.
    """
    found = []
    for name in named(action_names, "pos"):
        if name not in action:
            raise ControlError(f"the action has no '{name}'; it has {sorted(action)}")
        value = float(action[name])
        if not math.isfinite(value):
            raise ControlError(f"the action for '{name}' is {value}")
        found.append(value)
    return found
