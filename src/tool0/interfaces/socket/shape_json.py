"""Shapes of objects on the socket: a kind, and the keys of that kind beside it."""

from __future__ import annotations

from pathlib import Path

from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.errors import TransportError, did_you_mean
from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.wire import Json

_KINDS = ("box", "cylinder", "sphere", "mesh")


def shape_to_json(shape: Geometry) -> Json:
    """Return a shape as keys; a mesh by its absolute path, both ends being near."""
    match shape:
        case Box(size=size):
            return {"kind": "box", "size": list(size)}
        case Cylinder(radius=radius, length=length):
            return {"kind": "cylinder", "radius": radius, "length": length}
        case Sphere(radius=radius):
            return {"kind": "sphere", "radius": radius}
        case Mesh(path=path, scale=scale):
            return {"kind": "mesh", "file": str(path), "scale": list(scale)}


def shape_from_params(params: Params) -> Geometry:
    """Return the shape that a peer sent, or raise TransportError.

    Whether the file of a mesh is there is for the caller to say.
    """
    kind = params.text("kind")
    match kind:
        case "box":
            return Box(size=params.vector("size"))
        case "cylinder":
            return Cylinder(
                radius=params.number("radius"),
                length=params.number("length"),
            )
        case "sphere":
            return Sphere(radius=params.number("radius"))
        case "mesh":
            file = params.text("file")
            scale = params.vector("scale", (1.0, 1.0, 1.0))
            return Mesh(uri=file, path=Path(file), scale=scale)
    raise TransportError(
        f"no kind of shape '{kind}'{did_you_mean(kind, list(_KINDS))}; "
        f"use {', '.join(_KINDS)}"
    )
