"""Files that the requests of a peer may use; panel pages may use only some files."""

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
    """Files of this machine that the robot may read and write for a peer."""

    folders: Sequence[Path]
    """Folders with files that may be read and written, including files in
    subfolders."""
    known: Callable[[], Collection[Path]]
    """Function that returns other files that may be read.  Files of ROS packages may
    also be read."""

    resolve: Callable[[str], Path]
    """Function that returns the file of a URI, or raises Tool0Error."""

    def refusal(self, request: Request[Any]) -> ControlError | None:
        """Return the error for a request with a forbidden file, or None."""
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
        """Return whether a path is inside one of ``folders`` after resolving links."""
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
    """Return a path with resolved links; None if the path is not valid."""
    try:
        return Path(path).expanduser().resolve()
    except (OSError, RuntimeError, ValueError):
        return None
