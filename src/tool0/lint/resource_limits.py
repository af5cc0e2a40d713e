"""Runs a function in a child process with time and memory limits.

The limits are necessary because a user's xacro file is a program, and because ten lines
of YAML can contain a billion values.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from tool0.errors import Tool0Error
from tool0.installation.child_process import (
    ChildLimitExceededError,
    ChildProcessFailedError,
    call_in_child,
)

R = TypeVar("R")
P = ParamSpec("P")

TIMEOUT = 10.0
"""Time limit of a function [wall s].  Even the largest robots can be checked in a tenth
of this time."""
MEMORY = 2 << 30
"""Memory limit of the child process, in addition to the memory of this process
[bytes]."""


class ResourceLimitError(Tool0Error):
    """Raised if the work was aborted.  The message contains the reason."""


def run_limited(
    work: Callable[P, R],
    *arguments: P.args,
    **keywords: P.kwargs,
) -> R:
    """Return the result of ``work``, which must be picklable.

    Raises:
        ResourceLimitError: If ``work`` takes too long, uses too much memory or crashes.
        Exception: If ``work`` raises an exception.  The same exception is raised.
    """
    try:
        return call_in_child(
            lambda: work(*arguments, **keywords), timeout=TIMEOUT, memory=MEMORY
        )
    except ChildLimitExceededError as error:
        raise ResourceLimitError(
            f"it could not be read: {error}; look for a number that is far too large, "
            "or for a structure that contains itself"
        ) from None
    except ChildProcessFailedError as error:
        raise ResourceLimitError(f"it could not be read: {error}") from None
