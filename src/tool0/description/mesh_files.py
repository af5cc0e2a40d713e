"""The files of meshes: which can be read, and where they are."""

from __future__ import annotations

from pathlib import Path

from tool0.description.model import Mesh, Vector3
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


def mesh(file: Path | str, scale: float | Vector3 = 1.0) -> Mesh:
    """Return the shape in a file, STL or OBJ.

    Args:
        file: Its path, or ``package://``, ``file://``.
        scale: What its lengths are multiplied by to be [m], in all or each direction:
            0.001 for millimetres.

    Raises:
        DescriptionError: If it is not there, or of a kind that nothing reads.
    """
    path = find_mesh(str(file), None).absolute()
    three = (scale, scale, scale) if isinstance(scale, (int, float)) else scale
    return Mesh(uri=str(file), path=path, scale=three)
