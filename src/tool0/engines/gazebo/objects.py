"""The scene's objects as Gazebo takes them: a model of one link each, in SDF."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from tool0.description.model import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.description.scene import SceneObject
from tool0.engines.gazebo.solids import check_mesh, solid_of

STIFFNESS, DAMPING = 1e5, 10.0
"""Of contact [N/m, N·s/m], as of the pads: calm at rest, and no visible depth."""
MIN_DEPTH, MAX_VEL = 1e-5, 0.1
"""Overlap that is left alone [m], and the fastest that a deeper one is undone [m/s].

The direct solver overlooks the second; what holds instead is in bridge/preload.cc.
"""


def object_sdf(item: SceneObject) -> str:
    """Return the object as an SDF document, at its model's origin.

    Raises:
        ModelError: If it is a mesh that cannot be read, or one that encloses nothing
            and is to move.
    """
    if isinstance(item.geometry, Mesh):
        check_mesh(item.geometry.path)
    sdf = ET.Element("sdf", version="1.6")
    model = ET.SubElement(sdf, "model", name=item.name)
    _add(model, "static", "false" if item.mass else "true")
    link = ET.SubElement(model, "link", name="link")
    if item.mass is not None:
        _add_inertial(link, item, item.mass)
    collision = ET.SubElement(link, "collision", name="collision")
    collision.append(_geometry(item.geometry))
    _add_surface(collision, item.friction)
    visual = ET.SubElement(link, "visual", name="visual")
    visual.append(_geometry(item.geometry))
    material = ET.SubElement(visual, "material")
    colour = " ".join(map(repr, item.rgba))
    for tag in ("ambient", "diffuse"):
        _add(material, tag, colour)
    _add(visual, "transparency", repr(1.0 - item.rgba[3]))
    return ET.tostring(sdf, encoding="unicode")


def _add(parent: ET.Element, tag: str, text: str) -> None:
    ET.SubElement(parent, tag).text = text


def _geometry(geometry: Geometry) -> ET.Element:
    element = ET.Element("geometry")
    match geometry:
        case Box(size=size):
            _add(ET.SubElement(element, "box"), "size", " ".join(map(repr, size)))
        case Cylinder(radius=radius, length=length):
            shape = ET.SubElement(element, "cylinder")
            _add(shape, "radius", repr(radius))
            _add(shape, "length", repr(length))
        case Sphere(radius=radius):
            _add(ET.SubElement(element, "sphere"), "radius", repr(radius))
        case Mesh(path=path, scale=scale):
            shape = ET.SubElement(element, "mesh")
            _add(shape, "uri", path.as_uri())
            _add(shape, "scale", " ".join(map(repr, scale)))
    return element


def _add_inertial(link: ET.Element, item: SceneObject, mass: float) -> None:
    solid = solid_of(item.geometry)
    inertial = ET.SubElement(link, "inertial")
    _add(inertial, "pose", " ".join(repr(float(x)) for x in (*solid.center, 0, 0, 0)))
    _add(inertial, "mass", repr(mass))
    inertia = ET.SubElement(inertial, "inertia")
    for i, row in enumerate("xyz"):
        for j, column in enumerate("xyz"):
            if i <= j:
                moment = float(mass * solid.tensor[i, j])
                _add(inertia, f"i{row}{column}", repr(moment))


def _add_surface(collision: ET.Element, friction: float) -> None:
    surface = ET.SubElement(collision, "surface")
    ode = ET.SubElement(ET.SubElement(surface, "friction"), "ode")
    _add(ode, "mu", repr(friction))
    _add(ode, "mu2", repr(friction))
    contact = ET.SubElement(ET.SubElement(surface, "contact"), "ode")
    for tag, value in (
        ("kp", STIFFNESS),
        ("kd", DAMPING),
        ("min_depth", MIN_DEPTH),
        ("max_vel", MAX_VEL),
    ):
        _add(contact, tag, repr(value))
