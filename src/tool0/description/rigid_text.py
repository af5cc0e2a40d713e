"""The text of a simple model, which may come from anybody, read safely."""

from __future__ import annotations

from dataclasses import replace

from tool0.description.model import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.description.rigid_model import RigidModel
from tool0.description.rigid_sdf import read_rigid_sdf
from tool0.description.rigid_urdf import read_rigid_urdf
from tool0.description.xml_source import locate, parse_text
from tool0.errors import DescriptionError, ModelError

MAX_LENGTH = 1_000_000
"""Of the text [characters]: far more than one body needs, and read within a second."""
MAX_SIZE, MAX_MASS = 100.0, 1e6
"""[m, kg]: beyond them the physics of either engine goes astray."""
ROUGHEST = 1e6
"""[1] A larger friction is the same to a person, and not to the engines' figures."""


def read_rigid_model(text: str) -> RigidModel:
    """Return the model that ``text`` describes, in URDF or SDF.

    Raises:
        DescriptionError: If it cannot be read, or is no single body of one shape.
        ModelError: If nothing could be like this.
    """
    if len(text) > MAX_LENGTH:
        raise DescriptionError(
            f"the model's XML has {len(text)} characters; {MAX_LENGTH} is the most"
        )
    document = parse_text(text)
    root = document.documentElement
    match None if root is None else root.tagName:
        case "robot":
            return _bounded(read_rigid_urdf(document))
        case "sdf":
            return _bounded(read_rigid_sdf(document))
        case tag:
            raise DescriptionError(
                f"<{tag}> is no model; write a URDF's <robot>, or <sdf><model>",
                locate(root),
            )


def _bounded(model: RigidModel) -> RigidModel:
    """Return ``model`` with a friction that is no larger than it needs to be.

    Raises:
        ModelError: If its size, its mass or an offset is beyond all bounds.
    """
    sizes = _sizes(model.geometry)
    offsets = [
        value
        for frame in (model.placement, model.T_model_link, model.T_model_shape)
        for value in frame.position
    ]
    if not all(abs(value) <= MAX_SIZE for value in (*sizes, *offsets)):
        raise ModelError(
            f"model '{model.name}' has sizes {sizes} and offsets {offsets}; "
            f"{MAX_SIZE:g} m is the most"
        )
    if model.mass is not None and not model.mass <= MAX_MASS:
        raise ModelError(
            f"model '{model.name}' has a mass of {model.mass:g} kg; {MAX_MASS:g} kg "
            "is the most"
        )
    return replace(model, friction=min(model.friction, ROUGHEST))


def _sizes(geometry: Geometry) -> tuple[float, ...]:
    match geometry:
        case Box(size=size):
            return size
        case Cylinder(radius=radius, length=length):
            return radius, length
        case Sphere(radius=radius):
            return (radius,)
        case Mesh(scale=scale):
            return scale
