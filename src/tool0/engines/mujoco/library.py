"""Addresses of functions in MuJoCo's library, for compiled code."""

from __future__ import annotations

import contextlib
import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import mujoco


@cache
def mujoco_library() -> ctypes.CDLL | None:
    """Return MuJoCo's library, which is already loaded, or None if it is not found."""
    folder = Path(mujoco.__file__).parent
    for path in sorted(folder.glob("libmujoco.*")):
        with contextlib.suppress(OSError):
            return ctypes.CDLL(str(path))
    return None


def address_of(function: Any) -> int:
    """Return the address of a function of a library."""
    return int(ctypes.cast(function, ctypes.c_void_p).value or 0)


def variable_of(library: ctypes.CDLL, name: str) -> int:
    """Return the address of a variable of a library."""
    return ctypes.addressof(ctypes.c_void_p.in_dll(library, name))
