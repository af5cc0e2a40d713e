"""Mimic joints in Gazebo: by a gearbox joint where that is right, else by gear teeth.

ODE's gearbox holds w_child + ratio · w_parent = 0 between the angular velocities of two
bodies.  A relation between joints is about velocities against a third, which carries
both; its row has none.  So it is exact for ratio -1 and parallel axes alone, where the
carrier's velocity falls out.  With any other ratio it resists the turning of the
carrier and pushes on the two bodies with no reaction on the third.  There the bridge
lets teeth mesh between the two axes, as real gears do.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from tool0.description.model import Joint, JointType, RobotModel
from tool0.errors import ModelError
from tool0.hardware.bodies import Matrix, MovingBody

WORLD = "world"
"""What libsdformat fixes to the world if it is the URDF's root."""
_PARALLEL = 1e-6  # [rad]


@final
@dataclass(frozen=True, slots=True)
class MimicConstraint:
    """Holds a mimic joint to an adjacent joint of its mechanism."""

    joint: int
    """Index of the mimic joint among the movable ones."""
    other: int
    """Index of the joint that it is held to: of its parent body, or beside it."""
    multiplier: float
    """Position of the joint over that of the other."""
    is_gearbox: bool
    """Whether both turn the same way at the same speed, seen from the world."""


def mimic_constraints(
    model: RobotModel, bodies: tuple[MovingBody, ...], at_zero: list[Matrix]
) -> tuple[MimicConstraint, ...]:
    """Return the constraint of each mimic joint.

    Args:
        model: The robot.
        bodies: Its moving bodies.
        at_zero: Their poses with all joints at zero, shape (4, 4) each.

    Raises:
        ModelError: If Gazebo has no such constraint.
    """
    return tuple(
        _constraint(model, bodies, at_zero, i)
        for i, body in enumerate(bodies)
        if body.joint.mimic is not None
    )


def gearbox_sdf(
    model: RobotModel, bodies: tuple[MovingBody, ...], constraint: MimicConstraint
) -> ET.Element:
    """Return the gearbox joint of ``constraint``, in SDF."""
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
    model: RobotModel, bodies: tuple[MovingBody, ...], at_zero: list[Matrix], i: int
) -> MimicConstraint:
    body, joint = bodies[i], bodies[i].joint
    assert joint.mimic is not None
    if joint.mimic.offset:
        raise _refusal(model, joint, f"its offset is {joint.mimic.offset:g}")
    why, gear = "no joint of its mechanism is next to it", None
    for j in _neighbours(bodies, i):
        other = bodies[j].joint
        if JointType.PRISMATIC in (joint.type, other.type):
            why = f"it or '{other.name}' is prismatic"
            continue
        multiplier = joint.mimic.multiplier / _mimic_multiplier(other)
        along = _axis(bodies, at_zero, i) @ _axis(bodies, at_zero, j)
        if abs(along) < 1.0 - _PARALLEL:
            why = f"its axis is not parallel to that of '{other.name}'"
            continue
        if body.parent == j:
            # Carried by the other, it keeps its orientation seen from the body below.
            if np.isclose(multiplier * along, -1.0):
                return MimicConstraint(i, j, multiplier, is_gearbox=True)
            why = f"it is carried by '{other.name}' and does not turn back as far"
            continue
        if np.isclose(multiplier * along, 1.0):
            return MimicConstraint(i, j, multiplier, is_gearbox=True)
        gear = gear or MimicConstraint(i, j, multiplier, is_gearbox=False)
    if gear is None:
        raise _refusal(model, joint, why)
    return gear


def _neighbours(bodies: tuple[MovingBody, ...], i: int) -> Iterator[int]:
    """Yield joints of the same mechanism: that of the parent body, those beside it."""
    body = bodies[i]
    assert body.joint.mimic is not None
    for j in (body.parent, *range(i)):
        other = bodies[j].joint
        master = other.mimic.joint if other.mimic else other.name
        beside = j == body.parent or bodies[j].parent == body.parent
        is_one = j >= 0 and beside and master == body.joint.mimic.joint
        if is_one and _mimic_multiplier(other):
            yield j


def _axis(bodies: tuple[MovingBody, ...], at_zero: list[Matrix], i: int) -> Matrix:
    axis: Matrix = at_zero[i][:3, :3] @ np.asarray(bodies[i].joint.axis)
    return axis


def _mimic_multiplier(joint: Joint) -> float:
    return joint.mimic.multiplier if joint.mimic else 1.0


def _body_name(model: RobotModel, bodies: tuple[MovingBody, ...], body: int) -> str:
    """Return what libsdformat calls a body once it has merged the fixed links."""
    if body >= 0:
        return bodies[body].joint.child
    if model.root != WORLD:
        return model.root
    return model.child_joints[WORLD][0].child


def _refusal(model: RobotModel, joint: Joint, why: str) -> ModelError:
    return ModelError(
        f"Gazebo cannot make joint '{joint.name}' mimic another: {why}; "
        "use MuJoCo, or give it a transmission of its own",
        model.locations.get(f"joint:{joint.name}"),
    )
