"""The colours of a URDF's visuals, in the words that libsdformat understands.

It ignores ``<material>``, and its own extension colours a whole link.  But it lumps the
shapes of links that are fixed into the link that they are fixed to, each with the
extension of the link it comes from: so each coloured shape gets a link of its own.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

from tool0.description.model import RobotModel, Visual
from tool0.description.shapes import Mesh

_OWN = "tool0_paint"
"""Begins the links' names: a name that began with its parent's would not be lumped."""


def paint(robot: ET.Element, model: RobotModel) -> None:
    """Give the visuals of the URDF ``robot`` the colours that ``model`` read in it."""
    elements = {link.get("name"): link for link in robot.findall("link")}
    for link in model.links:
        element = elements[link.name]
        shapes = zip(link.visuals, element.findall("visual"), strict=True)
        for number, (visual, shape) in enumerate(shapes):
            if visual.rgba is not None and not _has_colours(visual):
                element.remove(shape)
                own = ET.SubElement(robot, "link", name=f"{_OWN}_{number}_{link.name}")
                own.append(shape)
                _fix(robot, link.name, own.get("name", ""))
                _colour(robot, own.get("name", ""), visual.rgba)


def _has_colours(visual: Visual) -> bool:
    """Return whether its file says which colours it has, as Collada does."""
    shape = visual.geometry
    return isinstance(shape, Mesh) and shape.path.suffix.lower() == ".dae"


def _fix(robot: ET.Element, parent: str, child: str) -> None:
    joint = ET.SubElement(robot, "joint", name=f"{child}_joint", type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)


def _colour(
    robot: ET.Element, link: str, rgba: tuple[float, float, float, float]
) -> None:
    extension = ET.SubElement(robot, "gazebo", reference=link)
    visual = ET.SubElement(extension, "visual")
    material = ET.SubElement(visual, "material")
    for tag in ("ambient", "diffuse"):
        ET.SubElement(material, tag).text = " ".join(map(repr, rgba))
    ET.SubElement(visual, "transparency").text = repr(1.0 - rgba[3])
