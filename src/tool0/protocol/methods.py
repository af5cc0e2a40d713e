"""The methods of the contract: each request by its name on a connection."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import Any, Final

from tool0.protocol.request import Request, method_name

_MODULES: Final = (
    "robot",
    "running",
    "updates",
    "motion",
    "trajectories",
    "goals",
    "poses",
    "controllers",
    "gripper",
    "arm",
    "arm_motion",
    "objects",
    "programs",
    "control_box",
    "hardware",
    "sensors",
    "recordings",
    "episodes",
    "replay",
)
"""Modules of this package that declare requests, in the order of the document."""


@cache
def methods() -> Mapping[str, type[Request[Any]]]:
    """Return every request class of the contract, by the name of its method."""
    found: dict[str, type[Request[Any]]] = {}
    for name in _MODULES:
        module = import_module(f"tool0.protocol.{name}")
        for value in vars(module).values():
            if (
                isinstance(value, type)
                and issubclass(value, Request)
                and value.__module__ == module.__name__
                and not value.__name__.startswith("_")
                and not getattr(value, "__parameters__", ())  # a base of others
            ):
                found[method_name(value)] = value
    return found
