"""Reading a simple model from SDF: one link with one collision shape."""

from __future__ import annotations

from xml.dom.minidom import Document, Element

from tool0.description.attributes import (
    child_number,
    only_child,
    required,
    required_child,
    text_of,
    to_number,
)
from tool0.description.kinematics import Transform, to_transform
from tool0.description.mesh_files import find_mesh
from tool0.description.model import Box, Cylinder, Geometry, Mesh, Pose, Sphere
from tool0.description.rigid_model import UNPAINTED, RigidModel, gazebo_colour
from tool0.description.scene import DEFAULT_FRICTION, RGBA
from tool0.description.xml_source import children, locate
from tool0.errors import DescriptionError

_TRUE = {"true", "1"}
_MANY = ("include", "model", "gripper")
"""Elements of a <model> that would make it more than one body."""
_DEFAULT_MASS = 1.0  # [kg] http://sdformat.org/spec?ver=1.6&elem=link#inertial_mass


def read_rigid_sdf(document: Document) -> RigidModel:
    """Return the model that an SDF describes.

    Raises:
        DescriptionError: If it cannot be read, or is no single body of one shape.
    """
    sdf = document.documentElement
    if sdf is None or sdf.tagName != "sdf":
        raise DescriptionError("the text holds no <sdf>", locate(sdf))
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
    is_static = _flag(model, "static") or _is_bolted(model, name)
    T_model_link = _pose(link)
    return RigidModel(
        name=name,
        geometry=_geometry(required_child(shape, "geometry")),
        link=required(link, "name"),
        collision=required(shape, "name"),
        T_model_link=T_model_link,
        T_model_shape=T_model_link @ _pose(shape),
        placement=_pose(model),
        mass=None if is_static else _mass(link),
        friction=_friction(shape),
        rgba=_colour(link),
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


def _flag(element: Element, tag: str) -> bool:
    child = only_child(element, tag)
    return child is not None and text_of(child).lower() in _TRUE


def _mass(link: Element) -> float:
    inertial = only_child(link, "inertial")
    mass = None if inertial is None else child_number(inertial, "mass")
    return _DEFAULT_MASS if mass is None else mass


def _pose(element: Element) -> Transform:
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


def _numbers(element: Element, count: int) -> list[float]:
    words = text_of(element).split()
    if len(words) != count:
        raise DescriptionError(
            f"<{element.tagName}> holds {len(words)} numbers; give {count}, separated "
            "by spaces",
            locate(element),
        )
    return [to_number(word, element, "its value") for word in words]


def _number(parent: Element, tag: str) -> float:
    (value,) = _numbers(required_child(parent, tag), 1)
    return value


def _geometry(element: Element) -> Geometry:
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
            return _mesh(shapes[0])
    raise DescriptionError(
        f"<geometry> holds {kind}; give one box, cylinder, sphere or mesh",
        locate(element),
    )


def _mesh(shape: Element) -> Mesh:
    element = required_child(shape, "uri")
    uri, location = text_of(element), locate(element)
    path = find_mesh(uri, location)
    scale = only_child(shape, "scale")
    x, y, z = (1.0, 1.0, 1.0) if scale is None else _numbers(scale, 3)
    return Mesh(uri=uri, path=path.absolute(), scale=(x, y, z))


def _friction(collision: Element) -> float:
    """Return ``mu`` of ``<surface><friction><ode>``."""
    element: Element | None = collision
    for tag in ("surface", "friction", "ode"):
        element = None if element is None else only_child(element, tag)
    mu = None if element is None else child_number(element, "mu")
    return DEFAULT_FRICTION if mu is None else mu


def _colour(link: Element) -> RGBA:
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
