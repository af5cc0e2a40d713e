"""The robot's URDF for Gazebo, and the constraints for mimic joints.

libsdformat converts the URDF, as it does for every user of Gazebo.  Before the
conversion, tool0 changes mesh paths, colors, the joint that fixes the robot to the
world, and the constraints and stops of mimic joints. tool0 also removes ROS 2
controller managers, since it replaces them.

A mimic joint is constrained by ODE's gearbox joint if this joint is exact.  Otherwise,
the bridge simulates gear teeth.  The gearbox enforces w_child + ratio · w_parent = 0
between the angular velocities of two bodies, but ignores the common carrier of the
bodies.  The gearbox is therefore exact only for ratio -1 and parallel axes, since the
carrier's velocity then cancels.  With any other ratio, the gearbox resists the
carrier's rotation without a reaction on the carrier.

The bridge simulates two prismatic joints on one carrier as two racks that mesh with a
pinion.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from tool0.description.bodies import Matrix, MovingBody
from tool0.description.model import Joint, JointType, Mimic, RobotModel, Visual
from tool0.description.shapes import Mesh
from tool0.errors import ModelError

WORLD = "world"
"""Name of a root link that libsdformat fixes to the world."""
_PARALLEL = 1e-6  # [rad]
STOP_SLACK = 0.02
"""Distance by which the stops of mimic joints in Gazebo are beyond those in the URDF
[rad | m].

The stop of a master joint also stops its mimic joints.  With redundant stops, ODE's
direct solver fails, and undamped fingers oscillate at 6 rad/s.
"""
_ROS2_CONTROL = "ros2_control"
"""Text in the file names of Gazebo plugins that run a ROS 2 controller manager."""
_COLORED = "tool0_paint"
"""Prefix of the links of colored shapes. libsdformat does not lump a link into its
parent if the link's name starts with the name of the parent."""


@final
@dataclass(frozen=True, slots=True)
class MimicConstraint:
    """Coupling of a mimic joint with an adjacent joint of the same mechanism."""

    joint: int
    """Index of the mimic joint among the movable joints."""
    other: int
    """Index of the joint coupled with the mimic joint.  The coupled joint is the joint
    of the parent body, or another joint on the same parent body."""
    multiplier: float
    """Ratio of the mimic joint's position to the other joint's position."""
    is_gearbox: bool
    """Whether a gearbox joint couples the two joints exactly.  Joints without a gearbox
    joint are coupled by the bridge."""


def mimic_constraints(
    model: RobotModel, bodies: tuple[MovingBody, ...]
) -> tuple[MimicConstraint, ...]:
    """Return the constraint of each mimic joint, or raise ModelError."""
    at_zero = body_poses(bodies, [0.0] * len(bodies))
    axes = [
        pose[:3, :3] @ np.asarray(body.joint.axis)
        for body, pose in zip(bodies, at_zero, strict=True)
    ]
    found = []
    for i, body in enumerate(bodies):
        if (mimic := body.joint.mimic) is not None:
            constraint = _constraint(bodies, axes, i, mimic)
            if isinstance(constraint, str):
                name = body.joint.name
                raise ModelError(
                    f"Gazebo cannot make joint '{name}' mimic another: {constraint}; "
                    "use MuJoCo, or give it a transmission of its own",
                    model.locations.get(f"joint:{name}"),
                )
            found.append(constraint)
    return tuple(found)


def gazebo_urdf(
    urdf: str,
    model: RobotModel,
    bodies: tuple[MovingBody, ...],
    constraints: tuple[MimicConstraint, ...],
) -> str:
    """Return the URDF of ``model`` for libsdformat, including the gearbox joints."""
    robot = ET.fromstring(urdf)
    shapes = [
        shape.geometry
        for link in model.links
        for shapes_of in (link.visuals, link.collisions)
        for shape in shapes_of
    ]
    files = {
        item.uri: item.path.absolute() for item in shapes if isinstance(item, Mesh)
    }
    for mesh in robot.iter("mesh"):
        mesh.set("filename", files[mesh.get("filename", "")].as_uri())
    if model.root != WORLD:
        robot.append(ET.Element("link", name=WORLD))
        _add_fixed_joint(robot, f"{WORLD}_joint", WORLD, model.root)
    _add_colors(robot, model)
    constrained = {bodies[c.joint].joint.child: c for c in constraints}
    mimics = {joint.name for joint in model.movable_joints if joint.mimic is not None}
    for joint in robot.iterfind("joint"):
        limit = joint.find("limit")
        if joint.get("name") in mimics and limit is not None:
            for side, back in (("lower", -STOP_SLACK), ("upper", STOP_SLACK)):
                limit.set(side, repr(float(limit.get(side, "0")) + back))
    geared = set()
    for extension in robot.iterfind("gazebo"):
        for plugin in extension.findall("plugin"):
            if _ROS2_CONTROL in plugin.get("filename", ""):
                extension.remove(plugin)
        for joint in extension.findall("joint[@type='gearbox']"):
            child = joint.findtext("child")
            if child in constrained and constrained[child].is_gearbox:
                geared.add(child)
            elif child in constrained:  # the bridge couples this joint instead
                extension.remove(joint)
    for child, constraint in constrained.items():
        if constraint.is_gearbox and child not in geared:
            extension = ET.SubElement(robot, "gazebo")
            extension.append(_gearbox_sdf(model, bodies, constraint))
    return ET.tostring(robot, encoding="unicode")


def _add_colors(robot: ET.Element, model: RobotModel) -> None:
    """Add the colors of ``model`` to the visuals of the URDF ``robot``.

    libsdformat ignores ``<material>``, and its extension for colors applies to a whole
    link.  A fixed link keeps its extension when it is lumped into its parent link.
    Therefore a separate link is created for each colored shape.
    """
    elements = {link.get("name"): link for link in robot.findall("link")}
    for link in model.links:
        element = elements[link.name]
        shapes = zip(link.visuals, element.findall("visual"), strict=True)
        for number, (visual, shape) in enumerate(shapes):
            if visual.rgba is not None and not _is_collada(visual):
                element.remove(shape)
                name = f"{_COLORED}_{number}_{link.name}"
                ET.SubElement(robot, "link", name=name).append(shape)
                _add_fixed_joint(robot, f"{name}_joint", link.name, name)
                _set_color(robot, name, visual.rgba)


def _is_collada(visual: Visual) -> bool:
    """Return whether the shape is a COLLADA mesh, which contains colors."""
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
    """Return the pose, shape (4, 4), of each movable joint's child link in the root.

    ``link_poses`` cannot be used, because its results differ in the last bit; see
    ``connection.quat_wxyz``.
    """
    poses: list[Matrix] = []
    for body, q in zip(bodies, position, strict=True):
        above = np.eye(4) if body.parent < 0 else poses[body.parent]
        poses.append(above @ body.placement @ _motion(body.joint, q))
    return poses


def _motion(joint: Joint, q: float) -> Matrix:
    """Return the displacement of the joint's child link at ``q``, shape (4, 4)."""
    motion = np.eye(4)
    axis = np.asarray(joint.axis)
    if joint.type is JointType.PRISMATIC:
        motion[:3, 3] = q * axis
        return motion
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    motion[:3, :3] += np.sin(q) * cross + (1.0 - np.cos(q)) * cross @ cross
    return motion


def _gearbox_sdf(
    model: RobotModel, bodies: tuple[MovingBody, ...], constraint: MimicConstraint
) -> ET.Element:
    """Return the SDF element of the gearbox joint for ``constraint``."""
    joint, parent = bodies[constraint.joint].joint, bodies[constraint.joint].parent
    is_carried = parent == constraint.other
    turned = bodies[constraint.other].parent if is_carried else constraint.other
    element = ET.Element("joint", name=f"{joint.name}_gearbox", type="gearbox")
    for tag, text in {
        "parent": _body_name(model, bodies, turned),
        "child": joint.child,
        "gearbox_reference_body": _body_name(model, bodies, parent),
        "gearbox_ratio": "-1",
    }.items():
        ET.SubElement(element, tag).text = text
    for tag in ("axis", "axis2"):
        xyz = ET.SubElement(ET.SubElement(element, tag), "xyz")
        xyz.text = " ".join(repr(float(part)) for part in joint.axis)
    return element


def _constraint(
    bodies: tuple[MovingBody, ...], axes: list[Matrix], i: int, mimic: Mimic
) -> MimicConstraint | str:
    """Return the constraint of joint ``i``, or the reason why there is none."""
    if mimic.offset:
        return f"its offset is {mimic.offset:g}"
    why, gear = "no joint of its mechanism is next to it", None
    for j in _neighbours(bodies, i, mimic):
        other = bodies[j].joint
        types = {bodies[i].joint.type, other.type}
        if JointType.PRISMATIC in types and len(types) > 1:
            why = f"only one of it and '{other.name}' is prismatic"
            continue
        multiplier = mimic.multiplier / _mimic_multiplier(other)
        along = axes[i] @ axes[j]
        if abs(along) < 1.0 - _PARALLEL:
            why = f"its axis is not parallel to that of '{other.name}'"
            continue
        if JointType.PRISMATIC in types:
            if bodies[i].parent != j:  # both are on one carrier
                return MimicConstraint(i, j, multiplier, is_gearbox=False)
            why = f"it slides on what '{other.name}' moves"
            continue
        if bodies[i].parent == j:
            # The mimic joint's body keeps its orientation relative to the carrier of
            # the other joint.
            if np.isclose(multiplier * along, -1.0):
                return MimicConstraint(i, j, multiplier, is_gearbox=True)
            why = f"it moves with '{other.name}' without turning back by the same angle"
            continue
        if np.isclose(multiplier * along, 1.0):
            return MimicConstraint(i, j, multiplier, is_gearbox=True)
        gear = gear or MimicConstraint(i, j, multiplier, is_gearbox=False)
    return gear or why


def _neighbours(bodies: tuple[MovingBody, ...], i: int, mimic: Mimic) -> Iterator[int]:
    """Yield the joints next to joint ``i`` in its mechanism, the parent joint first."""
    parent = bodies[i].parent
    for j in (parent, *range(i)):
        other = bodies[j].joint
        master = other.mimic.joint if other.mimic else other.name
        is_adjacent = j >= 0 and parent in (j, bodies[j].parent)
        if is_adjacent and master == mimic.joint and _mimic_multiplier(other):
            yield j


def _mimic_multiplier(joint: Joint) -> float:
    return joint.mimic.multiplier if joint.mimic else 1.0


def _body_name(model: RobotModel, bodies: tuple[MovingBody, ...], body: int) -> str:
    """Return libsdformat's name of a body after fixed links have been merged."""
    if body >= 0:
        return bodies[body].joint.child
    if model.root != WORLD:
        return model.root
    return model.child_joints[WORLD][0].child
