"""Meshes that tests write."""

from __future__ import annotations

import struct
from pathlib import Path

from tool0.description.shapes import Mesh

TETRAHEDRON = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def tetrahedron(path: Path) -> Mesh:
    """Write a tetrahedron with legs of 1 m, and return it at a tenth of that."""
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(c for i in face for c in TETRAHEDRON[i]), 0)
        for face in FACES
    )
    path.write_bytes(bytes(80) + struct.pack("<I", len(FACES)) + facets)
    return Mesh(uri=path.name, path=path, scale=(0.1, 0.1, 0.1))
