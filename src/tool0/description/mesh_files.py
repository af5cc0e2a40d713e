"""The files of meshes: which can be read, and where they are."""

from __future__ import annotations

from pathlib import Path

from tool0.description.packages import resolve_uri
from tool0.errors import DescriptionError, SourceLocation

MESH_SUFFIXES = (".dae", ".obj", ".stl")


def find_mesh(uri: str, location: SourceLocation | None) -> Path:
    """Return the file of a mesh.

    Args:
        uri: ``package://``, ``file://`` or a path.
        location: Where it is written, for messages.

    Raises:
        DescriptionError: If it is not there, or of a kind that nothing reads.
    """
    path = resolve_uri(uri, location)
    if path.suffix.lower() not in MESH_SUFFIXES:
        raise DescriptionError(
            f"nothing reads the mesh '{uri}'; convert it to one of "
            f"{', '.join(MESH_SUFFIXES)}",
            location,
        )
    if not path.is_file():
        raise DescriptionError(
            f"there is no mesh '{path}' (written '{uri}'); check the path", location
        )
    return path
