"""All functions of the library by name."""

from __future__ import annotations

from functools import cache
from typing import cast

from tool0.ur.urscript.functions import Function


@cache
def modules() -> dict[str, tuple[Function, ...]]:
    """Return the functions that programs can call, by the module that has them."""
    from tool0.ur.urscript.library import (
        arithmetic,
        controller,
        dynamics,
        force,
        gripper,
        inputs_outputs,
        modbus,
        motion,
        poses,
        program,
        registers,
        servers,
        settings,
        sockets,
        state,
        strings,
    )

    found = (
        *(
            arithmetic,
            controller,
            dynamics,
            force,
            gripper,
            inputs_outputs,
            modbus,
            motion,
            poses,
        ),
        *(program, registers, servers, settings, sockets, state, strings),
    )
    return {
        module.__name__.rpartition(".")[2]: cast(
            "tuple[Function, ...]", module.FUNCTIONS
        )
        for module in found
    }


@cache
def library() -> dict[str, Function]:
    """Return the functions that programs can call, by name."""
    return {item.name: item for items in modules().values() for item in items}
