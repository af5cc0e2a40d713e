"""The text of a simple model, which may come from anybody, read safely."""

from __future__ import annotations

from tool0.description.rigid_model import RigidModel
from tool0.description.rigid_sdf import read_rigid_sdf
from tool0.description.rigid_urdf import read_rigid_urdf
from tool0.description.xml_source import locate, parse_text
from tool0.errors import DescriptionError

MAX_LENGTH = 1_000_000
"""Of the text [characters]: far more than one body needs, and read within a second."""


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
            return read_rigid_urdf(document)
        case "sdf":
            return read_rigid_sdf(document)
        case tag:
            raise DescriptionError(
                f"<{tag}> is no model; write a URDF's <robot>, or <sdf><model>",
                locate(root),
            )
