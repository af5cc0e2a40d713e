"""Tables of all library functions by name and by module."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Final

from tool0.ur.urscript.functions import Function

_MODULES: Final = (
    *("arithmetic", "controller", "dynamics", "force", "gripper", "inputs_outputs"),
    *("modbus", "motion", "poses", "program", "registers", "servers", "settings"),
    *("sockets", "state", "strings"),
)


@cache
def modules() -> dict[str, tuple[Function, ...]]:
    """Return the functions that programs can call, grouped by module."""
    return {
        name: import_module(f"tool0.ur.urscript.library.{name}").FUNCTIONS
        for name in _MODULES
    }


@cache
def library() -> dict[str, Function]:
    """Return the functions that programs can call, by name."""
    return {item.name: item for items in modules().values() for item in items}
