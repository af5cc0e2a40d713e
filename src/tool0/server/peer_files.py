"""Files that a peer may name; panel pages may only name some of them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, Final, final

from tool0.errors import ControlError, Tool0Error
from tool0.protocol.request import Request, method_name

_PACKAGE: Final = "package://"


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PeerFiles:
    """Files of this machine that a peer may have the robot read and write."""

    folders: Sequence[Path]
    """Folders whose files, also in subfolders, a peer may have read and written."""
    known: Callable[[], Collection[Path]]
    """Function that returns other files which a peer may have read.  Files of ROS
    packages may be read, too."""

    resolve: Callable[[str], Path]
    """Function that returns the file of a URI, or raises Tool0Error."""

    def refusal(self, request: Request[Any]) -> ControlError | None:
        """Return why a request may not use one of its files; None if it may use all."""
        for field in request.written_paths:
            path = getattr(request, field)
            if path is not None and not self._is_inside(path):
                return self._refused(request, "writes only", path)
        for path in request.read_paths():
            if not self._may_read(path):
                what = "reads only files of ROS packages, meshes that this robot has, "
                return self._refused(request, f"{what}and those", path)
        return None

    def _refused(self, request: Request[Any], does: str, path: str) -> ControlError:
        allowed = " or ".join(map(str, self.folders))
        return ControlError(
            f"{method_name(type(request))}: a page {does} below {allowed}, "
            f"got {path!r}; `tool0 bringup --panel-folder FOLDER` allows another "
            "folder"
        )

    def _is_inside(self, path: str) -> bool:
        """Return whether a path leads into one of ``folders``, with links followed."""
        real = _real(path)
        return real is not None and any(
            real.is_relative_to(folder.resolve()) for folder in self.folders
        )

    def _may_read(self, uri: str) -> bool:
        if uri.startswith(_PACKAGE):
            return ".." not in PurePosixPath(uri.removeprefix(_PACKAGE)).parts
        try:
            path = str(self.resolve(uri))
        except Tool0Error:
            return False
        real = _real(path)
        known = {file.resolve() for file in self.known()}
        return self._is_inside(path) or real in known


def _real(path: str) -> Path | None:
    """Return a path with its links followed; None if it is not a valid path."""
    try:
        return Path(path).expanduser().resolve()
    except (OSError, RuntimeError, ValueError):
        return None
