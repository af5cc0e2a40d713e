"""Shapes on disk: binary STL files, and the YAML that the xacro files read."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from .model import Cylinder, LinkShape, ModelShape, Primitive
from .solid import Solid

HEADER = b"tool0 mesh, metres, in the link's frame".ljust(80)
PACKAGE = "package://tool0_description"
Meshes: TypeAlias = Mapping[tuple[str, str], str]
"""Link and material → URI of the mesh."""
_TRIANGLE = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
)


def write_models(models: Iterable[ModelShape], package: Path) -> list[Path]:
    """Write meshes and parameters of models below ``package``; return the files.

    A mesh that an earlier model has, too, is not written again: the parameters of both
    name the same file.
    """
    written: list[Path] = []
    uris: dict[bytes, str] = {}
    for model in models:
        folder = package / "meshes" / model.name / "visual"
        folder.mkdir(parents=True, exist_ok=True)
        meshes = {}
        for (link, material), data in _meshes(model).items():
            if data not in uris:
                file = folder / mesh_name(link, material)
                file.write_bytes(data)
                written.append(file)
                uris[data] = f"{PACKAGE}/{file.relative_to(package).as_posix()}"
            meshes[link, material] = uris[data]
        if not any(folder.iterdir()):
            folder.rmdir()
            folder.parent.rmdir()
        parameters = package / "config" / model.kind / model.name
        parameters.mkdir(parents=True, exist_ok=True)
        written.append(_write_parameters(model, meshes, parameters))
    return written


def write_own(model: ModelShape, folder: Path) -> list[Path]:
    """Write meshes and parameters of your own arm into its folder; return the files."""
    (folder / "meshes").mkdir(exist_ok=True)
    meshes, written = {}, []
    for (link, material), data in _meshes(model).items():
        file = folder / "meshes" / mesh_name(link, material)
        file.write_bytes(data)
        written.append(file)
        meshes[link, material] = file.relative_to(folder).as_posix()
    return [*written, _write_parameters(model, meshes, folder)]


def _meshes(model: ModelShape) -> dict[tuple[str, str], bytes]:
    """Return the STL files of a model by link and material."""
    return {
        (link, material): stl(solids)
        for link, shape in model.links.items()
        for material, solids in shape.visual.items()
    }


def _write_parameters(model: ModelShape, meshes: Meshes, folder: Path) -> Path:
    file = folder / "visual_parameters.yaml"
    file.write_text(visual_parameters(model, meshes), encoding="utf-8")
    return file


def mesh_name(link: str, material: str) -> str:
    """Return the name of the file that holds one material of one link."""
    return f"{link}_{material}.stl"


def stl(solids: Iterable[Solid]) -> bytes:
    """Return solids as one binary STL file."""
    corners = np.concatenate([solid.corners for solid in solids])
    a, b, c = corners.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    triangles = np.zeros(len(corners), dtype=_TRIANGLE)
    triangles["normal"] = np.round(normals, 4) + 0.0  # no last-bit noise, no -0.0
    triangles["corners"] = corners
    return HEADER + struct.pack("<I", len(corners)) + triangles.tobytes()


def visual_parameters(model: ModelShape, meshes: Meshes) -> str:
    """Return the text of a model's ``visual_parameters.yaml``."""
    lines = [
        "# What the links look like and where they can be touched, in the links' own",
        "# frames [m, rad]. Written by tools/make_meshes.py: change the shapes there.",
        "materials:  # red, green, blue, alpha",
    ]
    lines += [f"  {name}: {_list(rgba)}" for name, rgba in model.materials.items()]
    lines.append("links:")
    for link, shape in model.links.items():
        lines += [f"  {link}:", *_link(link, shape, meshes)]
    return "\n".join(lines) + "\n"


def _link(link: str, shape: LinkShape, meshes: Meshes) -> Iterable[str]:
    yield "    visual:"
    for material in shape.visual:
        yield f'      - {{mesh: "{meshes[link, material]}", material: {material}}}'
    yield "    collision:"
    for primitive in shape.collision:
        pose = f"xyz: {_list(primitive.xyz)}, rpy: {_list(primitive.rpy)}"
        yield f"      - {{{_geometry(primitive)}, {pose}}}"


def _geometry(primitive: Primitive) -> str:
    if isinstance(primitive, Cylinder):
        radius, length = _number(primitive.radius), _number(primitive.length)
        return f"cylinder: {{radius: {radius}, length: {length}}}"
    return f"box: {{size: {_list(primitive.size)}}}"


def _list(values: Sequence[float]) -> str:
    return f"[{', '.join(_number(value) for value in values)}]"


def _number(value: float) -> str:
    """Return a length to the micrometre, an angle to the microradian, as YAML."""
    text = f"{round(value, 6) + 0.0:.6f}".rstrip("0")
    return text + "0" if text.endswith(".") else text
