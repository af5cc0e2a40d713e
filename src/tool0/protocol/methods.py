"""Methods of the contract: request classes by their method names on a connection."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any, Final

from tool0.protocol.request import Request, method_name

_MODULES: Final = (
    "robot",
    "running",
    "subscriptions",
    "motion",
    "trajectories",
    "goals",
    "poses",
    "controllers",
    "gripper",
    "arm",
    "arm_motion",
    "planning",
    "objects",
    "programs",
    "control_box",
    "real_robot",
    "hardware",
    "sensors",
    "recordings",
    "reproduction",
    "episodes",
    "replay",
)
"""Modules of this package that declare requests, in the order of requests.md."""


_METHODS: Final[dict[str, type[Request[Any]]]] = {}


def methods() -> Mapping[str, type[Request[Any]]]:
    """Return every request class that connections accept, by method name."""
    if not _METHODS:
        _METHODS.update(contract())
    return _METHODS


@cache
def contract() -> Mapping[str, type[Request[Any]]]:
    """Return the request classes of this package, by method name."""
    found: dict[str, type[Request[Any]]] = {}
    for name in _MODULES:
        found |= _declared(import_module(f"tool0.protocol.{name}"))
    return found


def register(request: type[Request[Any]]) -> None:
    """Register a request of another package.

    Raises:
        TypeError: If another request has the same name.
    """
    name = method_name(request)
    if methods().get(name, request) is not request:
        raise TypeError(f"there is a request '{name}' already")
    _METHODS[name] = request


def _declared(module: ModuleType) -> dict[str, type[Request[Any]]]:
    """Return the request classes that a module declares, by method name."""
    return {
        method_name(value): value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Request)
        and value.__module__ == module.__name__
        and not getattr(value, "__parameters__", ())  # a base class
    }
