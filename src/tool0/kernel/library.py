"""Loading of the compiled kernel of this installation."""

from __future__ import annotations

import ctypes
import logging
import os
import shlex
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final, final

from tool0.errors import ConfigError
from tool0.kernel.build import FOLDER, LIBRARY, KernelUnusableError, open_library

logger = logging.getLogger(__name__)

VARIABLE: Final = "TOOL0_KERNEL"
"""Environment variable that selects the kernel.  The value ``python`` selects the
Python reference, which is slower but gives the same results."""
COMPILE_COMMAND: Final = shlex.join([sys.executable, "-m", "tool0.kernel.build"])


@final
@dataclass(frozen=True, slots=True)
class KernelStatus:
    """The compiled kernel, or the reason why the Python reference is used."""

    path: Path
    """Path of the library; the file may be missing."""
    library: ctypes.CDLL | None
    """The loaded library.  Calls of the library's functions release the interpreter's
    lock."""
    reason: str = ""
    """Reason why the library is not used; empty if it is used."""


def load() -> ctypes.CDLL | None:
    """Return the compiled kernel, or None if the Python reference must be used.

    Raises:
        ConfigError: If ``TOOL0_KERNEL`` has an unknown value.
    """
    return kernel_status().library


def kernel_status() -> KernelStatus:
    """Return the result of ``load``, or the reason why ``load`` returns None."""
    selected = os.environ.get(VARIABLE, "")
    if selected == "python":
        reason = f"{VARIABLE}=python selects the Python reference"
        return KernelStatus(FOLDER / LIBRARY, None, reason)
    if selected:
        raise ConfigError(
            f"unknown {VARIABLE}={selected!r}; valid: python, or unset it for the "
            "compiled kernel"
        )
    return _opened(FOLDER)


@cache
def _opened(folder: Path) -> KernelStatus:
    """Open the library in ``folder`` once per process, since opening takes 0.5 ms."""
    path = folder / LIBRARY
    try:
        return KernelStatus(path, open_library(folder))
    except KernelUnusableError as error:
        level = logging.WARNING if path.exists() else logging.INFO
        logger.log(
            level,
            "no compiled kernel, so the simulation is slower: %s; compile it: %s",
            error,
            COMPILE_COMMAND,
        )
        return KernelStatus(path, None, str(error))
