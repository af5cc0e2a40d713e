"""Parser of the URDF elements ``<link>`` and ``<joint>``, and of a joint's parts.

``<loop_joint>`` and ``<parallel_gripper>`` are elements that tool0 defines; other URDF
parsers ignore them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import partial
from xml.dom.minidom import Element

from tool0.description.model import (
    Collision,
    Inertial,
    Interface,
    Joint,
    JointLimits,
    JointType,
    LinearOpening,
    Link,
    LoopJoint,
    Mimic,
    ParallelGripper,
    RotaryOpening,
    SafetyController,
    Transmission,
    Visual,
    check_inertia,
    check_mass,
    check_protocol,
)
from tool0.description.shapes import (
    RGBA,
    SHAPES,
    Box,
    Geometry,
    check_geometry,
    read_geometry,
)
from tool0.description.transform import Vector3
from tool0.description.xml_source import (
    child_number,
    children,
    choice,
    locate,
    not_negative,
    number,
    numbers,
    only_child,
    origin,
    positive,
    require_known,
    required,
    required_child,
    text_of,
    vector,
)
from tool0.errors import ConfigError, DescriptionError, LimitsError, ModelError

SHEET = 1e-3
"""Thickness that replaces a zero edge length of a box, such as the height of a flat
floor [m]."""

_LIMITED = (JointType.REVOLUTE, JointType.PRISMATIC)
_WITH_AXIS = (*_LIMITED, JointType.CONTINUOUS, JointType.PLANAR)
_INTERFACE_PACKAGE = "hardware_interface/"


def read_link(element: Element, materials: Mapping[str, RGBA]) -> Link:
    """Return the link that ``element`` describes, with colors from ``materials``."""
    name = required(element, "name")
    return Link(
        name=name,
        inertial=read_inertial(element, name),
        visuals=tuple(
            Visual(
                geometry=_read_geometry(child),
                origin=origin(child),
                rgba=_read_rgba(child, materials),
            )
            for child in children(element, "visual")
        ),
        collisions=tuple(
            Collision(geometry=_read_geometry(child), origin=origin(child))
            for child in children(element, "collision")
        ),
    )


def read_inertial(link: Element, name: str) -> Inertial | None:
    """Return the ``<inertial>`` of a link, or None if there is no such element.

    A physically impossible inertia raises ModelError.
    """
    element = only_child(link, "inertial")
    if element is None:
        return None
    mass_element = required_child(element, "mass")
    mass = number(mass_element, "value")
    check_mass(mass, name, locate(mass_element))
    tensor = required_child(element, "inertia")
    moments = {key: number(tensor, key) for key in ("ixx", "iyy", "izz")}
    products = {key: number(tensor, key, 0.0) for key in ("ixy", "ixz", "iyz")}
    inertial = Inertial(mass=mass, origin=origin(element), **moments, **products)
    check_inertia(inertial, name, locate(tensor))
    return inertial


def _read_geometry(owner: Element) -> Geometry:
    element = required_child(owner, "geometry")
    shapes = list(children(element))
    if len(shapes) != 1:
        raise DescriptionError(
            f"<geometry> has {len(shapes)} shapes; give one of {', '.join(SHAPES)}",
            locate(shapes[1] if shapes else element),
        )
    (shape,) = shapes
    location = locate(shape)
    if shape.tagName == "capsule":
        raise DescriptionError(
            "no engine supports <capsule>; write a cylinder and two spheres", location
        )
    geometry = read_geometry(
        choice(shape.tagName, SHAPES, shape, "geometry"),
        partial(numbers, shape),
        lambda: (required(shape, "filename"), location),
    )
    if isinstance(geometry, Box) and geometry.size.count(0.0) == 1:
        x, y, z = (size or SHEET for size in geometry.size)
        geometry = Box(size=(x, y, z))
    try:
        check_geometry(geometry, f"of the <{owner.tagName}>")
    except ConfigError as error:
        raise DescriptionError(error.message, location) from None
    return geometry


def _read_rgba(visual: Element, materials: Mapping[str, RGBA]) -> RGBA | None:
    element = only_child(visual, "material")
    if element is None:
        return None
    return read_color(element) or materials.get(element.getAttribute("name"))


def read_color(material: Element) -> RGBA | None:
    """Return the ``<color>`` of a ``<material>``, or None if there is no color."""
    element = only_child(material, "color")
    if element is None:
        return None
    red, green, blue, alpha = rgba = numbers(element, "rgba", 4)
    if not (min(rgba) >= 0 and max(rgba) <= 1):
        raise DescriptionError(
            f"<color> has rgba {rgba}; each must be within 0 … 1", locate(element)
        )
    return red, green, blue, alpha


def read_joint(element: Element) -> Joint:
    """Return the joint that ``element`` describes."""
    name = required(element, "name")
    types = [kind.value for kind in JointType]
    kind = JointType(choice(required(element, "type"), types, element, "joint type"))
    dynamics = only_child(element, "dynamics")
    damping, friction = (
        0.0
        if dynamics is None
        else not_negative(number(dynamics, key, 0.0), f"<dynamics> has {key}", dynamics)
        for key in ("damping", "friction")
    )
    mimic = only_child(element, "mimic")
    return Joint(
        name=name,
        type=kind,
        parent=required(required_child(element, "parent"), "link"),
        child=required(required_child(element, "child"), "link"),
        origin=origin(element),
        axis=_read_axis(element, name) if kind in _WITH_AXIS else (1.0, 0.0, 0.0),
        limits=_read_limits(element, name, kind),
        damping=damping,
        friction=friction,
        mimic=None
        if mimic is None
        else Mimic(
            joint=required(mimic, "joint"),
            multiplier=number(mimic, "multiplier", 1.0),
            offset=number(mimic, "offset", 0.0),
        ),
        safety=_read_safety(element),
    )


def _read_axis(element: Element, name: str) -> Vector3:
    child = only_child(element, "axis")
    if child is None:
        return (1.0, 0.0, 0.0)  # URDF's default
    x, y, z = vector(child, "xyz")
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 1e-9:
        raise ModelError(
            f"joint '{name}' has a zero axis; give a direction such as 0 0 1",
            locate(child),
        )
    return (x / length, y / length, z / length)


def _read_limits(element: Element, name: str, kind: JointType) -> JointLimits:
    child = only_child(element, "limit")
    is_limited = kind in _LIMITED
    if kind is JointType.FIXED:
        return JointLimits()  # ROS does not read the limits of these joints
    if child is None:
        if is_limited:
            raise LimitsError(
                f"{kind.value} joint '{name}' lacks "
                '<limit lower="…" upper="…" effort="…" velocity="…"/>; '
                "a joint without limits is of type continuous",
                locate(element),
            )
        return JointLimits()
    # urdfdom requires velocity and effort; only continuous joints may omit them
    otherwise = None if is_limited else math.inf
    velocity = number(child, "velocity", otherwise)
    effort = number(child, "effort", otherwise)
    try:
        return JointLimits(
            lower=number(child, "lower", 0.0) if is_limited else -math.inf,
            upper=number(child, "upper", 0.0) if is_limited else math.inf,
            velocity=velocity,
            effort=effort,
        )
    except LimitsError as error:
        raise LimitsError(f"joint '{name}': {error.message}", locate(child)) from None


def _read_safety(element: Element) -> SafetyController | None:
    child = only_child(element, "safety_controller")
    if child is None:
        return None
    safety = SafetyController(
        soft_lower_limit=number(child, "soft_lower_limit", -math.inf),
        soft_upper_limit=number(child, "soft_upper_limit", math.inf),
        k_position=number(child, "k_position", 0.0),
        k_velocity=number(child, "k_velocity", 0.0),
    )
    if not safety.soft_lower_limit <= safety.soft_upper_limit:
        raise LimitsError(
            f"soft lower limit {safety.soft_lower_limit} is above "
            f"soft upper limit {safety.soft_upper_limit}; use a smaller margin",
            locate(child),
        )
    return safety


def read_transmission(
    element: Element, drives: Mapping[str, Transmission]
) -> Transmission:
    """Return the transmission that ``element`` describes, as ros_control reads it.

    If ``drives`` already contains a drive of this joint, the data of the transmission
    is added to that drive.
    """
    joint = required_child(element, "joint")
    actuator = only_child(element, "actuator")
    reduction = inertia = None
    carries_weight = False
    if actuator is not None:
        flag = only_child(actuator, "gravityCompensation")
        if flag is not None:
            value = choice(text_of(flag), ("true", "false"), flag, "boolean")
            carries_weight = value == "true"
        reduction = child_number(actuator, "mechanicalReduction")
        inertia = child_number(actuator, "rotorInertia")
    if reduction == 0 or (inertia is not None and not inertia >= 0):
        raise ModelError(
            f"<actuator> has reduction {reduction} and rotor inertia {inertia}; "
            "the one must not be zero, the other not negative",
            locate(actuator),
        )
    name = required(joint, "name")
    drive = drives.get(name) or Transmission(
        name=required(element, "name"),
        joint=name,
        interfaces=(_read_interface(element, joint, actuator),),
    )
    return replace(
        drive,
        mechanical_reduction=drive.mechanical_reduction
        if reduction is None
        else reduction,
        rotor_inertia=drive.rotor_inertia if inertia is None else inertia,
        gravity_compensation=drive.gravity_compensation or carries_weight,
    )


def _read_interface(
    element: Element, joint: Element, actuator: Element | None
) -> Interface:
    """Return the interface in ``joint``, or in ``actuator`` if ``joint`` has none."""
    valid = [item.value for item in Interface]
    for owner in (joint, actuator):
        for named in () if owner is None else children(owner, "hardwareInterface"):
            text = text_of(named)
            full = text if "/" in text else _INTERFACE_PACKAGE + text
            return Interface(choice(full, valid, named, "hardware interface"))
    raise DescriptionError(
        "<transmission> names no <hardwareInterface> in its <joint>; "
        f"give one of {', '.join(valid)}",
        locate(element),
    )


def read_loop(element: Element, links: Collection[str]) -> LoopJoint:
    """Return the loop joint that ``element`` describes between two of ``links``."""
    name = required(element, "name")
    ends = list(children(element, "end"))
    if len(ends) != 2:
        raise DescriptionError(
            f"<loop_joint> '{name}' has {len(ends)} <end>; give two, "
            'as <end link="…" xyz="…"/>',
            locate(element),
        )
    first, second = (required(end, "link") for end in ends)
    for link, end in zip((first, second), ends, strict=True):
        what = f"<loop_joint> '{name}' ends at the unknown link"
        require_known(link, links, what, locate(end))
    if first == second:
        raise ModelError(
            f"<loop_joint> '{name}' joins '{first}' to itself; name two links",
            locate(element),
        )
    return LoopJoint(
        name=name,
        links=(first, second),
        points=(vector(ends[0], "xyz"), vector(ends[1], "xyz")),
    )


_ROTARY, _LINEAR = ("pad_cos", "pad_sin"), ("pad_slope",)


def read_gripper(element: Element, joints: Mapping[str, Joint]) -> ParallelGripper:
    """Return the gripper that ``element`` describes; one of ``joints`` drives it."""
    name, driven = required(element, "name"), required(element, "joint")
    what = f"gripper '{name}' is driven by the unknown joint"
    require_known(driven, joints, what, locate(element))
    speed = (positive(element, "min_speed"), positive(element, "max_speed"))
    force = (positive(element, "min_force"), positive(element, "max_force"))
    if not (speed[0] <= speed[1] and force[0] <= force[1]):
        raise LimitsError(
            f"<parallel_gripper> has speeds {speed} and forces {force}; "
            "the smaller comes first",
            locate(element),
        )
    protocol = element.getAttribute("protocol").strip() or None
    if protocol is not None:
        check_protocol(protocol, locate(element))
    gripper = ParallelGripper(
        name=name,
        joint=driven,
        protocol=protocol,
        law=_read_opening_law(element, name, joints[driven]),
        max_opening=positive(element, "max_opening"),
        speed=speed,
        force=force,
        passive=tuple(
            (joint.name, joint.mimic)
            for joint in joints.values()
            if joint.passive and joint.mimic and joint.mimic.joint == driven
        ),
    )
    for opening in (0.0, gripper.max_opening):
        try:
            gripper.position(opening)
        except (ValueError, ZeroDivisionError):
            raise ModelError(
                f"the linkage of gripper '{name}' reaches no opening of "
                f"{opening} m; check pad_offset, pad_cos and pad_sin",
                locate(element),
            ) from None
    return gripper


def _read_opening_law(
    element: Element, name: str, joint: Joint
) -> RotaryOpening | LinearOpening:
    """Return the relation between the opening of gripper ``name`` and its ``joint``."""
    is_linear = any(map(element.hasAttribute, _LINEAR))
    if is_linear == any(map(element.hasAttribute, _ROTARY)):
        raise DescriptionError(
            f"gripper '{name}' needs either pad_cos and pad_sin (its joint turns) or "
            "pad_slope (it slides)",
            locate(element),
        )
    offset = number(element, "pad_offset")
    law: RotaryOpening | LinearOpening
    if is_linear:
        law = LinearOpening(pad_offset=offset, pad_slope=number(element, "pad_slope"))
        if not law.pad_slope < 0.0:
            raise ModelError(
                f"gripper '{name}' has pad_slope {law.pad_slope:g}: it opens as "
                f"'{joint.name}' grows, but must close; turn the joint's axis round",
                locate(element),
            )
    else:
        law = RotaryOpening(
            pad_offset=offset,
            pad_cos=number(element, "pad_cos"),
            pad_sin=number(element, "pad_sin"),
        )
    if is_linear != (joint.type is JointType.PRISMATIC):
        given = " and ".join(_LINEAR if is_linear else _ROTARY)
        raise ModelError(
            f"gripper '{name}' is driven by the {joint.type.value} joint "
            f"'{joint.name}', but with {given} it must "
            + ("slide (prismatic)" if is_linear else "turn"),
            locate(element),
        )
    return law
