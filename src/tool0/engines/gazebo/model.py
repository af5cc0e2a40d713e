"""The robot's URDF as Gazebo needs it.

Gazebo's own libsdformat converts it, so that what a Gazebo user would get is what
runs.  Three things are settled before: where meshes are, that the robot is fixed to
the world, and a gearbox for each mimic joint for which the URDF brings none.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

import numpy as np

from tool0.description.model import Joint, JointType, RobotModel
from tool0.description.packages import resolve_uri
from tool0.errors import ModelError
from tool0.hardware.bodies import Matrix, MovingBody, moving_bodies

WORLD = "world"
"""What libsdformat fixes to the world if it is the URDF's root."""


def gazebo_urdf(urdf: str, model: RobotModel) -> str:
    """Return the URDF of ``model`` for libsdformat.

    Raises:
        ModelError: If a mimic joint is none that a gearbox can be.
    """
    robot = ET.fromstring(urdf)
    for mesh in robot.iter("mesh"):
        mesh.set("filename", resolve_uri(mesh.get("filename", "")).as_uri())
    if model.root != WORLD:
        robot.append(ET.Element("link", name=WORLD))
        joint = ET.SubElement(robot, "joint", name=f"{WORLD}_joint", type="fixed")
        ET.SubElement(joint, "parent", link=WORLD)
        ET.SubElement(joint, "child", link=model.root)
    geared = {
        child.text
        for joint in robot.iterfind("gazebo/joint[@type='gearbox']")
        if (child := joint.find("child")) is not None
    }
    for gearbox in _gearboxes(model, geared):
        ET.SubElement(robot, "gazebo").append(gearbox)
    return ET.tostring(robot, encoding="unicode")


def joint_poses(
    model: RobotModel, bodies: tuple[MovingBody, ...], position: list[float]
) -> list[Matrix]:
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


def _gearboxes(model: RobotModel, geared: set[str | None]) -> Iterator[ET.Element]:
    """Yield a gearbox for each mimic joint whose child is not ``geared``.

    Gazebo's gearbox holds w_child + ratio · w_parent = 0 about axis and axis2, which
    are given in the child's frame; both turn against the reference body.
    """
    bodies = moving_bodies(model)
    at_zero = joint_poses(model, bodies, [0.0] * len(bodies))
    for i, body in enumerate(bodies):
        joint = body.joint
        if joint.mimic is None or joint.child in geared:
            continue
        other = _neighbour(model, bodies, i)
        multiplier = joint.mimic.multiplier / _multiplier(bodies[other].joint)
        if body.parent == other:  # it rides on the other, which so turns the other way
            ratio, parent = multiplier, bodies[other].parent
        else:
            ratio, parent = -multiplier, other
        turn = at_zero[i][:3, :3].T @ at_zero[other][:3, :3]
        element = ET.Element("joint", name=f"{joint.name}_gearbox", type="gearbox")
        for tag, text in {
            "parent": _body_name(model, bodies, parent),
            "child": joint.child,
            "gearbox_reference_body": _body_name(model, bodies, body.parent),
            "gearbox_ratio": repr(float(ratio)),
        }.items():
            ET.SubElement(element, tag).text = text
        for tag, axis in (
            ("axis", np.asarray(joint.axis)),
            ("axis2", turn @ np.asarray(bodies[other].joint.axis)),
        ):
            xyz = ET.SubElement(ET.SubElement(element, tag), "xyz")
            xyz.text = " ".join(repr(float(part)) for part in axis)
        yield element


def _multiplier(joint: Joint) -> float:
    return joint.mimic.multiplier if joint.mimic else 1.0


def _neighbour(model: RobotModel, bodies: tuple[MovingBody, ...], i: int) -> int:
    """Return a body that moves with the ``i``-th and shares a link with it.

    It is the one that carries it, or an earlier one on the same parent: the master
    or another that follows it.
    """
    body, joint = bodies[i], bodies[i].joint
    assert joint.mimic is not None
    if joint.mimic.offset:
        raise _no_gearbox(model, joint, f"its offset is {joint.mimic.offset:g}")
    for j in (body.parent, *range(i)):
        other = bodies[j].joint
        master = other.mimic.joint if other.mimic else other.name
        if j < 0 or master != joint.mimic.joint or not _multiplier(other):
            continue
        if JointType.PRISMATIC in (joint.type, other.type):
            raise _no_gearbox(model, joint, f"it or '{other.name}' is prismatic")
        if j == body.parent or bodies[j].parent == body.parent:
            return j
    raise _no_gearbox(model, joint, "no link of its mechanism is next to it")


def _body_name(model: RobotModel, bodies: tuple[MovingBody, ...], body: int) -> str:
    """Return what libsdformat calls a body once it has merged the fixed links."""
    if body >= 0:
        return bodies[body].joint.child
    if model.root != WORLD:
        return model.root
    return model.child_joints[WORLD][0].child


def _no_gearbox(model: RobotModel, joint: Joint, why: str) -> ModelError:
    return ModelError(
        f"Gazebo cannot make joint '{joint.name}' mimic another: {why}; "
        "use MuJoCo, or give it a transmission of its own",
        model.locations.get(f"joint:{joint.name}"),
    )
