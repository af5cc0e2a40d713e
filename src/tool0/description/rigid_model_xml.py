"""Reading a simple model from the text of an untrusted URDF or SDF.

A simple model is one rigid body with one collision shape.
"""

from __future__ import annotations

from dataclasses import replace
from xml.dom.minidom import Document, Element

from tool0.description.attributes import (
    child_number,
    only_child,
    required,
    required_child,
    text_of,
    to_numbers,
)
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import Collision, Link, RobotModel
from tool0.description.rigid_model import UNPAINTED, RigidModel, gazebo_colour
from tool0.description.scene import DEFAULT_FRICTION, RGBA
from tool0.description.shapes import (
    Box,
    Cylinder,
    Geometry,
    Mesh,
    Sphere,
    find_mesh,
)
from tool0.description.transform import Pose, Transform, to_transform
from tool0.description.urdf import read_model
from tool0.description.xml_source import children, locate, parse_text
from tool0.errors import DescriptionError, ModelError

MAX_LENGTH = 1_000_000
"""Of the text [characters]: far more than one body needs, and read within a second."""
MAX_SIZE, MAX_MASS = 100.0, 1e6
"""[m, kg]: beyond them the physics of either engine diverges."""
MAX_FRICTION = 1e6
"""[1] A larger friction changes no motion, and only spoils the engines' numerics."""

_WORLD = "world"
"""The name of a root link that Gazebo takes for the world itself."""
_TRUE = {"true", "1"}
_MANY = ("include", "model", "gripper")
"""Elements of an SDF <model> that would make it more than one body."""
_DEFAULT_MASS = 1.0  # [kg] http://sdformat.org/spec?ver=1.6&elem=link#inertial_mass


def read_rigid_model(text: str) -> RigidModel:
    """Return the model that ``text`` describes, in URDF or SDF.

    Raises:
        DescriptionError: If it cannot be read, or is no single body of one shape.
        ModelError: If nothing could be like this.
    """
    if len(text) > MAX_LENGTH:
        raise DescriptionError(
            f"the model's XML has {len(text)} characters; {MAX_LENGTH} is the most"
        )
    document = parse_text(text)
    root = document.documentElement
    if root is not None and root.tagName == "robot":
        return _bounded(_read_urdf(document, list(children(root, "gazebo"))))
    if root is not None and root.tagName == "sdf":
        return _bounded(_read_sdf(root))
    tag = None if root is None else root.tagName
    raise DescriptionError(
        f"<{tag}> is no model; write a URDF's <robot>, or <sdf><model>", locate(root)
    )


def _bounded(model: RigidModel) -> RigidModel:
    """Return ``model`` with a friction that is no larger than it needs to be.

    Raises:
        ModelError: If its size, its mass or an offset is too large.
    """
    sizes = _sizes(model.geometry)
    offsets = [
        value
        for frame in (model.placement, model.T_model_link, model.T_model_shape)
        for value in frame.position
    ]
    if not all(abs(value) <= MAX_SIZE for value in (*sizes, *offsets)):
        raise ModelError(
            f"model '{model.name}' has sizes {sizes} and offsets {offsets}; "
            f"{MAX_SIZE:g} m is the most"
        )
    if model.mass is not None and not model.mass <= MAX_MASS:
        raise ModelError(
            f"model '{model.name}' has a mass of {model.mass:g} kg; {MAX_MASS:g} kg "
            "is the most"
        )
    return replace(model, friction=min(model.friction, MAX_FRICTION))


def _sizes(geometry: Geometry) -> tuple[float, ...]:
    match geometry:
        case Box(size=size):
            return size
        case Cylinder(radius=radius, length=length):
            return radius, length
        case Sphere(radius=radius):
            return (radius,)
        case Mesh(scale=scale):
            return scale


def _read_urdf(document: Document, extensions: list[Element]) -> RigidModel:
    model = read_model(document)
    if model.movable_joints:
        names = ", ".join(f"'{joint.name}'" for joint in model.movable_joints)
        raise DescriptionError(
            f"model '{model.name}' has joints that move, {names}: only one rigid "
            "body can be spawned; write fixed joints, or leave them out"
        )
    link, shape = _one_shape(model)
    poses = link_poses(model)
    base = model.root
    if base == _WORLD and model.child_joints[base]:
        base = model.child_joints[base][0].child
    mu1 = None if link.surface is None else link.surface.mu1
    return RigidModel(
        name=model.name,
        geometry=shape.geometry,
        link=base,
        collision=f"{link.name}_collision",
        T_model_link=poses[base],
        T_model_shape=poses[link.name] @ to_transform(shape.origin),
        mass=_urdf_mass(model, extensions),
        friction=DEFAULT_FRICTION if mu1 is None else mu1,
        rgba=_urdf_colour(model, extensions),
    )


def _one_shape(model: RobotModel) -> tuple[Link, Collision]:
    shapes = [(link, shape) for link in model.links for shape in link.collisions]
    if len(shapes) != 1:
        raise DescriptionError(
            f"model '{model.name}' has {len(shapes)} <collision> shapes; what is "
            "spawned has exactly one"
        )
    return shapes[0]


def _urdf_mass(model: RobotModel, extensions: list[Element]) -> float | None:
    """Return the mass of all links [kg]; None of what stands still."""
    if model.root == _WORLD or any(
        text_of(flag).lower() in _TRUE
        for extension in extensions
        for flag in children(extension, "static")
    ):
        return None
    mass = sum(link.inertial.mass for link in model.links if link.inertial is not None)
    if not mass:
        raise DescriptionError(
            f"model '{model.name}' has no mass; give its link an <inertial>, or write "
            "<gazebo><static>true</static></gazebo>"
        )
    return mass


def _urdf_colour(model: RobotModel, extensions: list[Element]) -> RGBA:
    """Return the colour for Gazebo if one is named, else the first visual's."""
    for extension in extensions:
        material = only_child(extension, "material")
        named = None if material is None else gazebo_colour(text_of(material))
        if named is not None:
            return named
    visuals = [visual for link in model.links for visual in link.visuals]
    return next((v.rgba for v in visuals if v.rgba is not None), UNPAINTED)


def _read_sdf(sdf: Element) -> RigidModel:
    model = required_child(sdf, "model")
    name = required(model, "name")
    for tag in _MANY:
        for element in children(model, tag):
            raise DescriptionError(
                f"<{tag}> in model '{name}' is not supported: only one rigid body can "
                "be spawned",
                locate(element),
            )
    link = _one(model, "link", name)
    shape = _one(link, "collision", name)
    is_static = _sdf_flag(model, "static") or _is_bolted(model, name)
    T_model_link = _sdf_pose(link)
    return RigidModel(
        name=name,
        geometry=_sdf_geometry(required_child(shape, "geometry")),
        link=required(link, "name"),
        collision=required(shape, "name"),
        T_model_link=T_model_link,
        T_model_shape=T_model_link @ _sdf_pose(shape),
        placement=_sdf_pose(model),
        mass=None if is_static else _sdf_mass(link),
        friction=_sdf_friction(shape),
        rgba=_sdf_colour(link),
    )


def _one(parent: Element, tag: str, name: str) -> Element:
    found = list(children(parent, tag))
    if len(found) != 1:
        raise DescriptionError(
            f"model '{name}' has {len(found)} <{tag}> in <{parent.tagName}>; what is "
            "spawned has exactly one",
            locate(found[1] if found else parent),
        )
    return found[0]


def _is_bolted(model: Element, name: str) -> bool:
    """Return whether a fixed joint holds the link to the world."""
    joints = list(children(model, "joint"))
    for joint in joints:
        parent = text_of(required_child(joint, "parent"))
        if joint.getAttribute("type") != "fixed" or parent != "world":
            raise DescriptionError(
                f"model '{name}' has a joint '{joint.getAttribute('name')}': only a "
                "fixed one to the world is supported",
                locate(joint),
            )
    return bool(joints)


def _sdf_flag(element: Element, tag: str) -> bool:
    child = only_child(element, tag)
    return child is not None and text_of(child).lower() in _TRUE


def _sdf_mass(link: Element) -> float:
    inertial = only_child(link, "inertial")
    mass = None if inertial is None else child_number(inertial, "mass")
    return _DEFAULT_MASS if mass is None else mass


def _sdf_pose(element: Element) -> Transform:
    child = only_child(element, "pose")
    if child is None:
        return Transform()
    for attribute in ("frame", "relative_to"):
        if child.getAttribute(attribute):
            raise DescriptionError(
                f"<pose {attribute}=…> is not supported; write the pose in the parent",
                locate(child),
            )
    x, y, z, roll, pitch, yaw = _numbers(child, 6) if text_of(child) else [0.0] * 6
    return to_transform(Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw)))


def _numbers(element: Element, count: int) -> tuple[float, ...]:
    return to_numbers(text_of(element), count, element, "its text")


def _number(parent: Element, tag: str) -> float:
    (value,) = _numbers(required_child(parent, tag), 1)
    return value


def _sdf_geometry(element: Element) -> Geometry:
    shapes = list(children(element))
    kind = shapes[0].tagName if len(shapes) == 1 else f"{len(shapes)} shapes"
    match kind:
        case "box":
            x, y, z = _numbers(required_child(shapes[0], "size"), 3)
            return Box(size=(x, y, z))
        case "cylinder":
            return Cylinder(
                radius=_number(shapes[0], "radius"), length=_number(shapes[0], "length")
            )
        case "sphere":
            return Sphere(radius=_number(shapes[0], "radius"))
        case "mesh":
            return _sdf_mesh(shapes[0])
    raise DescriptionError(
        f"<geometry> holds {kind}; give one box, cylinder, sphere or mesh",
        locate(element),
    )


def _sdf_mesh(shape: Element) -> Mesh:
    element = required_child(shape, "uri")
    uri, location = text_of(element), locate(element)
    path = find_mesh(uri, location)
    scale = only_child(shape, "scale")
    x, y, z = (1.0, 1.0, 1.0) if scale is None else _numbers(scale, 3)
    return Mesh(uri=uri, path=path.absolute(), scale=(x, y, z))


def _sdf_friction(collision: Element) -> float:
    """Return ``mu`` of ``<surface><friction><ode>``."""
    element: Element | None = collision
    for tag in ("surface", "friction", "ode"):
        element = None if element is None else only_child(element, tag)
    mu = None if element is None else child_number(element, "mu")
    return DEFAULT_FRICTION if mu is None else mu


def _sdf_colour(link: Element) -> RGBA:
    for visual in children(link, "visual"):
        material = only_child(visual, "material")
        if material is None:
            continue
        for tag in ("diffuse", "ambient"):
            colour = only_child(material, tag)
            if colour is not None:
                return _rgba(colour)
        script = only_child(material, "script")
        name = None if script is None else only_child(script, "name")
        named = None if name is None else gazebo_colour(text_of(name))
        if named is not None:
            return named
    return UNPAINTED


def _rgba(element: Element) -> RGBA:
    opaque = len(text_of(element).split()) == 3
    red, green, blue, *alpha = _numbers(element, 3 if opaque else 4)
    return red, green, blue, alpha[0] if alpha else 1.0
