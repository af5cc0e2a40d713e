"""Where a peer may have files written: pages only in some folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tool0.errors import ControlError
from tool0.protocol.request import Request, method_name


def refusal(request: Request[Any], folders: Sequence[Path]) -> ControlError | None:
    """Return why a request may not write where it says; None if it may.

    Args:
        request: A request with ``written_paths``.
        folders: Those in which, and below which, its peer may have files written.
    """
    for field in request.written_paths:
        path = getattr(request, field)
        if path is not None and not _is_inside(path, folders):
            allowed = " or ".join(map(str, folders))
            return ControlError(
                f"{method_name(type(request))}: a page writes only below {allowed}, "
                f"got {path!r}; `tool0 bringup --panel-folder FOLDER` allows another "
                "folder"
            )
    return None


def _is_inside(path: str, folders: Sequence[Path]) -> bool:
    """Return whether a path leads into one of ``folders``, links followed."""
    try:
        real = Path(path).expanduser().resolve()
    except (OSError, RuntimeError, ValueError):
        return False
    return any(real.is_relative_to(folder.resolve()) for folder in folders)
