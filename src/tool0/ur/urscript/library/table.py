"""All functions of the library by name."""

from __future__ import annotations

from functools import cache
from typing import cast

from tool0.ur.urscript.functions import Function


@cache
def library() -> dict[str, Function]:
    """Return the functions that programs can call."""
    from tool0.ur.urscript.library import (
        arithmetic,
        force,
        gripper,
        inputs_outputs,
        motion,
        poses,
        program,
        registers,
        settings,
        sockets,
        state,
        strings,
    )

    modules = (
        *(arithmetic, force, gripper, inputs_outputs, motion, poses, program),
        *(registers, settings, sockets, state, strings),
    )
    found: dict[str, Function] = {}
    for module in modules:
        for item in cast("tuple[Function, ...]", module.FUNCTIONS):
            found[item.name] = item
    return found
