"""The robot's URDF as Gazebo needs it.

Gazebo's own libsdformat converts it, so that what a Gazebo user would get is what
runs.  Five things are changed before: the paths of meshes, the joint that fixes the
robot to the world, the constraints and the stops of mimic joints, and colours.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from tool0.description.model import Joint, JointType, RobotModel, Visual
from tool0.description.packages import resolve_uri
from tool0.description.shapes import Mesh
from tool0.engines.gazebo.mimic import WORLD, MimicConstraint, gearbox_sdf
from tool0.hardware.bodies import Matrix, MovingBody

STOP_SLACK = 0.02
"""By how much the stops of mimic joints are set back [rad | m].

A master's stop holds its mimics, too: ODE's direct solver fails on redundant rows, and
undamped fingers then oscillate at 6 rad/s.
"""


_COLORED = "tool0_paint"
"""Starts the names of coloured shapes' links: libsdformat does not lump a link whose
name begins with its parent's."""


def gazebo_urdf(
    urdf: str,
    model: RobotModel,
    bodies: tuple[MovingBody, ...],
    constraints: tuple[MimicConstraint, ...],
) -> str:
    """Return the URDF of ``model`` for libsdformat, with its gearboxes."""
    robot = ET.fromstring(urdf)
    for mesh in robot.iter("mesh"):
        mesh.set("filename", resolve_uri(mesh.get("filename", "")).as_uri())
    if model.root != WORLD:
        robot.append(ET.Element("link", name=WORLD))
        _add_fixed_joint(robot, f"{WORLD}_joint", WORLD, model.root)
    add_colors(robot, model)
    constrained = {bodies[c.joint].joint.child: c for c in constraints}
    mimics = {joint.name for joint in model.movable_joints if joint.mimic is not None}
    for joint in robot.iterfind("joint"):
        limit = joint.find("limit")
        if joint.get("name") in mimics and limit is not None:
            for side, back in (("lower", -STOP_SLACK), ("upper", STOP_SLACK)):
                limit.set(side, repr(float(limit.get(side, "0")) + back))
    geared = set()
    for extension in robot.iterfind("gazebo"):
        for joint in extension.findall("joint[@type='gearbox']"):
            child = joint.findtext("child")
            if child in constrained and constrained[child].is_gearbox:
                geared.add(child)
            elif child in constrained:  # the bridge holds it instead
                extension.remove(joint)
    for child, constraint in constrained.items():
        if constraint.is_gearbox and child not in geared:
            extension = ET.SubElement(robot, "gazebo")
            extension.append(gearbox_sdf(model, bodies, constraint))
    return ET.tostring(robot, encoding="unicode")


def add_colors(robot: ET.Element, model: RobotModel) -> None:
    """Give the visuals of the URDF ``robot`` the colours that ``model`` has.

    libsdformat ignores ``<material>``, and its own extension colours a whole link.  It
    lumps the shapes of fixed links into their parent link, but each keeps the extension
    of its own link: so each coloured shape gets a link of its own.
    """
    elements = {link.get("name"): link for link in robot.findall("link")}
    for link in model.links:
        element = elements[link.name]
        shapes = zip(link.visuals, element.findall("visual"), strict=True)
        for number, (visual, shape) in enumerate(shapes):
            if visual.rgba is not None and not _has_own_colors(visual):
                element.remove(shape)
                name = f"{_COLORED}_{number}_{link.name}"
                ET.SubElement(robot, "link", name=name).append(shape)
                _add_fixed_joint(robot, f"{name}_joint", link.name, name)
                _set_color(robot, name, visual.rgba)


def _has_own_colors(visual: Visual) -> bool:
    """Return whether the mesh file has colours, as Collada does."""
    shape = visual.geometry
    return isinstance(shape, Mesh) and shape.path.suffix.lower() == ".dae"


def _add_fixed_joint(robot: ET.Element, name: str, parent: str, child: str) -> None:
    joint = ET.SubElement(robot, "joint", name=name, type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)


def _set_color(
    robot: ET.Element, link: str, rgba: tuple[float, float, float, float]
) -> None:
    extension = ET.SubElement(robot, "gazebo", reference=link)
    visual = ET.SubElement(extension, "visual")
    material = ET.SubElement(visual, "material")
    for tag in ("ambient", "diffuse"):
        ET.SubElement(material, tag).text = " ".join(map(repr, rgba))
    ET.SubElement(visual, "transparency").text = repr(1.0 - rgba[3])


def body_poses(bodies: tuple[MovingBody, ...], position: list[float]) -> list[Matrix]:
    """Return each movable joint's child link in the robot's root, shape (4, 4)."""
    poses: list[Matrix] = []
    for body, q in zip(bodies, position, strict=True):
        above = np.eye(4) if body.parent < 0 else poses[body.parent]
        poses.append(above @ body.placement @ _motion(body.joint, q))
    return poses


def _motion(joint: Joint, q: float) -> Matrix:
    """Return how far the joint moves its child at ``q``, shape (4, 4)."""
    motion = np.eye(4)
    axis = np.asarray(joint.axis)
    if joint.type is JointType.PRISMATIC:
        motion[:3, 3] = q * axis
        return motion
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    motion[:3, :3] += np.sin(q) * cross + (1.0 - np.cos(q)) * cross @ cross
    return motion
