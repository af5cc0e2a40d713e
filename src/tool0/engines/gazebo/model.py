"""The robot's URDF as Gazebo needs it.

Gazebo's own libsdformat converts it, so that what a Gazebo user would get is what
runs.  Five things are settled before: where meshes are, that the robot is fixed to the
world, what holds the mimic joints, which stops stay out of the way, and colours.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from tool0.description.model import Joint, JointType, RobotModel
from tool0.description.packages import resolve_uri
from tool0.engines.gazebo.colours import paint
from tool0.engines.gazebo.couplings import WORLD, Coupling, gearbox
from tool0.hardware.bodies import Matrix, MovingBody

STOP_SLACK = 0.02
"""By how much the stops of mimic joints are set back [rad | m].

Where a master's stop holds, those of its mimics hold already: ODE's direct solver gives
up on rows that say the same, and undamped fingers then hammer at 6 rad/s.
"""


def gazebo_urdf(
    urdf: str,
    model: RobotModel,
    bodies: tuple[MovingBody, ...],
    couplings: tuple[Coupling, ...],
) -> str:
    """Return the URDF of ``model`` for libsdformat, with its gearboxes."""
    robot = ET.fromstring(urdf)
    for mesh in robot.iter("mesh"):
        mesh.set("filename", resolve_uri(mesh.get("filename", "")).as_uri())
    if model.root != WORLD:
        robot.append(ET.Element("link", name=WORLD))
        joint = ET.SubElement(robot, "joint", name=f"{WORLD}_joint", type="fixed")
        ET.SubElement(joint, "parent", link=WORLD)
        ET.SubElement(joint, "child", link=model.root)
    paint(robot, model)
    links = {bodies[c.joint].joint.child: c for c in couplings}
    loose = {joint.name for joint in model.movable_joints if joint.mimic is not None}
    for joint in robot.iterfind("joint"):
        limit = joint.find("limit")
        if joint.get("name") in loose and limit is not None:
            for side, back in (("lower", -STOP_SLACK), ("upper", STOP_SLACK)):
                limit.set(side, repr(float(limit.get(side, "0")) + back))
    geared = set()
    for extension in robot.iterfind("gazebo"):
        for joint in extension.findall("joint[@type='gearbox']"):
            child = joint.findtext("child")
            if child in links and links[child].is_gearbox:
                geared.add(child)
            elif child in links:  # the bridge does what this one cannot
                extension.remove(joint)
    for child, coupling in links.items():
        if coupling.is_gearbox and child not in geared:
            extension = ET.SubElement(robot, "gazebo")
            extension.append(gearbox(model, bodies, coupling))
    return ET.tostring(robot, encoding="unicode")


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
