"""A small robot with every kind of joint that an engine must master."""

from __future__ import annotations

from tool0.description.model import (
    Inertial,
    Interface,
    Joint,
    JointLimits,
    JointType,
    Link,
    Mimic,
    RobotModel,
    Transmission,
)
from tool0.description.transform import Pose


def link(name: str, mass: float, *xyz: float) -> Link:
    x, y, z = xyz
    inertial = Inertial(
        mass=mass,
        origin=Pose(xyz=(x, y, z), rpy=(0.3, -0.2, 0.1)),
        ixx=0.010 * mass,
        iyy=0.014 * mass,
        izz=0.008 * mass,
    )
    return Link(name=name, inertial=inertial)


LINKS = (
    Link(name="world"),
    link("mount", 5.0, 0.0, 0.0, 0.0),
    link("upper", 3.0, 0.01, 0.02, 0.2),
    link("lower", 2.0, 0.0, -0.01, 0.15),
    link("cap", 0.4, 0.05, 0.0, 0.0),
    link("rod", 0.6, 0.0, 0.03, 0.1),
    link("flap", 0.3, 0.1, 0.0, 0.0),
)
LIMITS = JointLimits(lower=-2.8, upper=2.8, velocity=3.0, effort=150.0)
JOINTS = (
    Joint(name="base", type=JointType.FIXED, parent="world", child="mount"),
    Joint(
        name="lift",
        type=JointType.REVOLUTE,
        parent="mount",
        child="upper",
        axis=(0.0, 1.0, 0.0),
        origin=Pose(xyz=(0.1, 0.0, 0.2)),
        limits=LIMITS,
    ),
    Joint(
        name="bend",
        type=JointType.REVOLUTE,
        parent="upper",
        child="lower",
        axis=(0.6, 0.8, 0.0),
        origin=Pose(xyz=(0.0, 0.02, 0.4), rpy=(0.3, 0.2, 0.1)),
        limits=LIMITS,
    ),
    Joint(
        name="cap_joint",
        type=JointType.FIXED,
        parent="lower",
        child="cap",
        origin=Pose(xyz=(0.0, 0.0, 0.3), rpy=(0.0, 0.5, 0.0)),
    ),
    Joint(
        name="slide",
        type=JointType.PRISMATIC,
        parent="cap",
        child="rod",
        axis=(0.0, 0.6, 0.8),
        origin=Pose(xyz=(0.0, 0.0, 0.1)),
        limits=JointLimits(lower=-0.2, upper=0.2, velocity=0.5, effort=200.0),
    ),
    Joint(
        name="follower",
        type=JointType.REVOLUTE,
        parent="lower",
        child="flap",
        axis=(0.0, 0.0, 1.0),
        origin=Pose(xyz=(0.1, 0.0, 0.3), rpy=(1.2, 0.0, 0.4)),
        limits=LIMITS,
        mimic=Mimic(joint="bend", multiplier=-0.5, offset=0.2),
    ),
)


def build_model(*interfaces: Interface) -> RobotModel:
    """Three joints in skew directions, one of them prismatic, and one that mimics.

    Effort drives them without ``interfaces``.
    """
    offered = interfaces or (Interface.EFFORT,)
    return RobotModel(
        name="skew",
        root="world",
        links=LINKS,
        joints=JOINTS,
        transmissions=tuple(
            Transmission(name=f"{name}_drive", joint=name, interfaces=offered)
            for name in ("lift", "bend", "slide")
        ),
    )
