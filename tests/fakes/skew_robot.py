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


def inertial(mass: float, xyz: tuple[float, float, float]) -> Inertial:
    return Inertial(
        mass=mass,
        origin=Pose(xyz=xyz, rpy=(0.3, -0.2, 0.1)),
        ixx=0.010 * mass,
        iyy=0.014 * mass,
        izz=0.008 * mass,
    )


def build_model(interface: Interface = Interface.EFFORT) -> RobotModel:
    """Three joints in skew directions, one of them prismatic, and one that mimics."""
    limits = JointLimits(lower=-2.8, upper=2.8, velocity=3.0, effort=150.0)
    joints = (
        Joint(
            name="lift",
            type=JointType.REVOLUTE,
            parent="mount",
            child="upper",
            axis=(0.0, 1.0, 0.0),
            origin=Pose(xyz=(0.1, 0.0, 0.2)),
            limits=limits,
        ),
        Joint(
            name="bend",
            type=JointType.REVOLUTE,
            parent="upper",
            child="lower",
            axis=(0.6, 0.8, 0.0),
            origin=Pose(xyz=(0.0, 0.02, 0.4), rpy=(0.3, 0.2, 0.1)),
            limits=limits,
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
            limits=limits,
            mimic=Mimic(joint="bend", multiplier=-0.5, offset=0.2),
        ),
    )
    fixed = (
        Joint(name="base", type=JointType.FIXED, parent="world", child="mount"),
        Joint(
            name="cap_joint",
            type=JointType.FIXED,
            parent="lower",
            child="cap",
            origin=Pose(xyz=(0.0, 0.0, 0.3), rpy=(0.0, 0.5, 0.0)),
        ),
    )
    links = (
        Link(name="world"),
        Link(name="mount", inertial=inertial(5.0, (0.0, 0.0, 0.0))),
        Link(name="upper", inertial=inertial(3.0, (0.01, 0.02, 0.2))),
        Link(name="lower", inertial=inertial(2.0, (0.0, -0.01, 0.15))),
        Link(name="cap", inertial=inertial(0.4, (0.05, 0.0, 0.0))),
        Link(name="rod", inertial=inertial(0.6, (0.0, 0.03, 0.1))),
        Link(name="flap", inertial=inertial(0.3, (0.1, 0.0, 0.0))),
    )
    base, cap = fixed
    lift, bend, slide, follower = joints
    return RobotModel(
        name="skew",
        root="world",
        links=links,
        joints=(base, lift, bend, cap, slide, follower),
        transmissions=tuple(
            Transmission(name=f"{name}_drive", joint=name, interface=interface)
            for name in ("lift", "bend", "slide")
        ),
    )
