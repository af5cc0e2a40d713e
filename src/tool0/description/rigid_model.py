"""Parser of simple models in URDF or SDF text from untrusted sources.

A simple model is one rigid body with one or more collision shapes.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import final
from xml.dom.minidom import Document, Element

from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.scene import DEFAULT_FRICTION, LONGEST_MODEL, SceneObject
from tool0.description.shapes import (
    RGBA,
    SHAPES,
    Compound,
    Geometry,
    Solid,
    placed_geometries,
    read_geometry,
    sizes,
)
from tool0.description.transform import Pose, Transform, to_pose, to_transform
from tool0.description.units import within_a_turn
from tool0.description.urdf import read_model
from tool0.description.urdf_elements import read_inertial
from tool0.description.xml_source import (
    child_number,
    children,
    locate,
    only_child,
    parse_text,
    required,
    required_child,
    text_of,
    to_numbers,
)
from tool0.errors import DescriptionError, ModelError, SourceLocation

logger = logging.getLogger(__name__)

MAX_SIZE, MAX_MASS = 100.0, 1e6
"""Largest size [m] and mass [kg] of a model.  With larger values, the physics of both
engines diverges."""
MAX_FRICTION = 1e6
"""Largest coefficient of friction.  A larger coefficient would not change any motion
and would only degrade the engines' numerical accuracy."""

_WORLD = "world"
"""Name of a root link that Gazebo treats as the world."""
_TRUE = {"true", "1"}
_MANY = ("include", "model", "gripper")
"""Elements of an SDF <model> that would add further bodies to the model."""
_DEFAULT_MASS = 1.0  # [kg] http://sdformat.org/spec?ver=1.6&elem=link#inertial_mass

_UNPAINTED: RGBA = (0.7, 0.7, 0.7, 1.0)
"""Gray, the color in which Gazebo shows shapes without a stated color."""
_GAZEBO_COLOURS: dict[str, RGBA] = {
    "black": (0.0, 0.0, 0.0, 1.0),
    "blue": (0.0, 0.0, 1.0, 1.0),
    "darkgrey": (0.175, 0.175, 0.175, 1.0),
    "green": (0.0, 1.0, 0.0, 1.0),
    "grey": (0.7, 0.7, 0.7, 1.0),
    "indigo": (0.33, 0.0, 0.5, 1.0),
    "orange": (1.0, 0.51, 0.0, 1.0),
    "purple": (1.0, 0.0, 1.0, 1.0),
    "red": (1.0, 0.0, 0.0, 1.0),
    "turquoise": (0.0, 1.0, 1.0, 1.0),
    "white": (1.0, 1.0, 1.0, 1.0),
    "wood": (0.65, 0.5, 0.33, 1.0),
    "yellow": (1.0, 1.0, 0.0, 1.0),
}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RigidModel:
    """The model of an object, including the frames that Gazebo uses for the object."""

    name: str
    """Name of the model in the URDF or SDF document."""
    geometry: Solid
    link: str = "link"
    collisions: tuple[str, ...] = ("collision",)
    """Names of the shape's parts, in the same order as the parts."""
    T_model_link: Transform = field(default_factory=Transform)
    T_model_shape: Transform = field(default_factory=Transform)
    """Pose of the shape's origin in the model.  The shape's origin is also the object's
    origin."""
    placement: Transform = field(default_factory=Transform)
    """Pose in the model's ``<pose>`` element, relative to the pose at which the model
    is placed."""
    mass: float | None = None
    """Mass [kg]; None for a static body."""
    friction: float = DEFAULT_FRICTION
    rgba: RGBA = _UNPAINTED

    def scene_object(self, name: str, T_root_model: Transform) -> SceneObject:
        """Return the object at a pose of the model, or raise ConfigError."""
        return SceneObject(
            name=name,
            geometry=self.geometry,
            pose=to_pose(T_root_model @ self.T_model_shape),
            mass=self.mass,
            friction=self.friction,
            rgba=self.rgba,
        )


def read_rigid_model(text: str) -> RigidModel:
    """Return the model that ``text`` describes, in URDF or SDF.

    Raises:
        DescriptionError: If the text cannot be read, or the model is not a single body.
        ModelError: If a parameter of the model is physically impossible.
    """
    if len(text) > LONGEST_MODEL:
        raise DescriptionError(
            f"the model's XML has {len(text)} characters; {LONGEST_MODEL} is the most"
        )
    document = parse_text(text)
    root = document.documentElement
    tag = None if root is None else root.tagName
    if root is not None and tag == "robot":
        return _bounded(_read_urdf(document, root))
    if root is not None and tag == "sdf":
        return _bounded(_read_sdf(root))
    raise DescriptionError(
        f"<{tag}> is no model; write a URDF's <robot>, or <sdf><model>", locate(root)
    )


def mesh_uris(text: str) -> tuple[str, ...]:
    """Return the URIs of the meshes in a model; none if the text is not XML."""
    try:
        meshes = parse_text(text).getElementsByTagName("mesh")
    except DescriptionError:
        return ()
    of_sdf = (text_of(child) for mesh in meshes for child in children(mesh, "uri"))
    of_urdf = (mesh.getAttribute("filename") for mesh in meshes)
    return tuple(uri for uri in (*of_urdf, *of_sdf) if uri)


def _bounded(model: RigidModel) -> RigidModel:
    """Return ``model`` with its friction limited to ``MAX_FRICTION``.

    Raises:
        ModelError: If the model's size, mass or an offset is too large.
    """
    parts = placed_geometries(model.geometry)
    extents = [size for geometry, _ in parts for size in sizes(geometry)]
    frames = (model.placement, model.T_model_link, model.T_model_shape)
    offsets = [
        *(value for frame in frames for value in frame.position),
        *(value for _, pose in parts for value in pose.xyz),
    ]
    if not all(abs(value) <= MAX_SIZE for value in (*extents, *offsets)):
        raise ModelError(
            f"model '{model.name}' has sizes {extents} and offsets {offsets}; "
            f"{MAX_SIZE:g} m is the most"
        )
    if model.mass is not None and not model.mass <= MAX_MASS:
        raise ModelError(
            f"model '{model.name}' has a mass of {model.mass:g} kg; {MAX_MASS:g} kg "
            "is the most"
        )
    return replace(model, friction=min(model.friction, MAX_FRICTION))


def _read_urdf(document: Document, robot: Element) -> RigidModel:
    _replace_impossible_inertia(robot)
    model = read_model(document)
    if model.movable_joints:
        names = ", ".join(f"'{joint.name}'" for joint in model.movable_joints)
        raise DescriptionError(
            f"model '{model.name}' has joints that move, {names}: only one rigid "
            "body can be spawned; write fixed joints, or leave them out"
        )
    shapes = [(link, shape) for link in model.links for shape in link.collisions]
    if not shapes:
        raise DescriptionError(
            f"model '{model.name}' has no <collision> shape; give its link one"
        )
    poses = link_poses(model)
    base = model.root
    if base == _WORLD and model.child_joints[base]:
        base = model.child_joints[base][0].child
    frictions = (link.surface.mu1 for link, _ in shapes if link.surface is not None)
    extensions = list(children(robot, "gazebo"))
    geometry, T_model_shape = _joined(
        poses[base],
        [
            (shape.geometry, poses[link.name] @ to_transform(shape.origin))
            for link, shape in shapes
        ],
    )
    return RigidModel(
        name=model.name,
        geometry=geometry,
        link=base,
        collisions=tuple(
            f"{link.name}_collision" + (f"_{number}" if number else "")
            for link in model.links
            for number in range(len(link.collisions))
        ),
        T_model_link=poses[base],
        T_model_shape=T_model_shape,
        mass=_urdf_mass(model, extensions),
        friction=next((mu for mu in frictions if mu is not None), DEFAULT_FRICTION),
        rgba=_urdf_colour(model, extensions),
    )


def _joined(
    T_model_link: Transform, placed: Sequence[tuple[Geometry, Transform]]
) -> tuple[Solid, Transform]:
    """Return placed shapes as one shape, and the pose of this shape in the model.

    If there are several shapes, the pose is that of the shapes' link.
    """
    if len(placed) == 1:
        return placed[0]
    T_link_model = T_model_link.inverse()
    parts = tuple((shape, to_pose(T_link_model @ pose)) for shape, pose in placed)
    return Compound(parts=parts), T_model_link


def _replace_impossible_inertia(robot: Element) -> None:
    """Replace impossible inertias, so that the document can be parsed.

    The replaced values are not used: the inertia of an object is computed from its
    shape and mass.
    """
    for link in children(robot, "link"):
        tensor = _descendant(link, "inertial", "inertia")
        try:
            read_inertial(link, link.getAttribute("name"))
        except ModelError as error:
            if tensor is None or error.location != locate(tensor):
                raise
            logger.warning("%s; it is not used: shape and mass decide", error)
            for axes, moment in {"xx yy zz": "1", "xy xz yz": "0"}.items():
                for axis in axes.split():
                    tensor.setAttribute(f"i{axis}", moment)


def _urdf_mass(model: RobotModel, extensions: list[Element]) -> float | None:
    """Return the total mass of all links [kg]; None if the model is static."""
    if model.root == _WORLD or any(_flag(item, "static") for item in extensions):
        return None
    mass = sum(link.inertial.mass for link in model.links if link.inertial is not None)
    if not mass:
        raise DescriptionError(
            f"model '{model.name}' has no mass; give its link an <inertial>, or write "
            "<gazebo><static>true</static></gazebo>"
        )
    return mass


def _urdf_colour(model: RobotModel, extensions: list[Element]) -> RGBA:
    """Return the color of the Gazebo material, or the color of the first visual."""
    for extension in extensions:
        named = _gazebo_colour(only_child(extension, "material"))
        if named is not None:
            return named
    visuals = [visual for link in model.links for visual in link.visuals]
    return next((v.rgba for v in visuals if v.rgba is not None), _UNPAINTED)


def _gazebo_colour(element: Element | None) -> RGBA | None:
    """Return the color of a material such as ``Gazebo/Red``; None for a texture."""
    name = "" if element is None else text_of(element)
    return _GAZEBO_COLOURS.get(name.removeprefix("Gazebo/").lower())


def _read_sdf(sdf: Element) -> RigidModel:
    for element in children(sdf, "include"):
        raise DescriptionError(
            "<include> is not supported: give the <model> itself, not its URI",
            locate(element),
        )
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
    shapes = list(children(link, "collision"))
    if not shapes:
        raise DescriptionError(
            f"link '{required(link, 'name')}' of model '{name}' has no <collision>; "
            "give it one",
            locate(link),
        )
    is_static = _flag(model, "static") or _is_bolted(model, name)
    inertial = only_child(link, "inertial")
    mass = None if inertial is None else child_number(inertial, "mass")
    surfaces = (_descendant(shape, "surface", "friction", "ode") for shape in shapes)
    frictions = (child_number(ode, "mu") for ode in surfaces if ode is not None)
    T_model_link = _sdf_pose(link)
    geometry, T_model_shape = _joined(
        T_model_link,
        [
            (
                _sdf_geometry(required_child(shape, "geometry")),
                T_model_link @ _sdf_pose(shape),
            )
            for shape in shapes
        ],
    )
    return RigidModel(
        name=name,
        geometry=geometry,
        link=required(link, "name"),
        collisions=tuple(required(shape, "name") for shape in shapes),
        T_model_link=T_model_link,
        T_model_shape=T_model_shape,
        placement=_sdf_pose(model),
        mass=None if is_static else _DEFAULT_MASS if mass is None else mass,
        friction=next((mu for mu in frictions if mu is not None), DEFAULT_FRICTION),
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


def _descendant(element: Element | None, *tags: str) -> Element | None:
    """Return the descendant with the path ``tags``, or None if there is none."""
    for tag in tags:
        element = None if element is None else only_child(element, tag)
    return element


def _is_bolted(model: Element, name: str) -> bool:
    """Return whether a fixed joint connects the model to the world."""
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
    return any(text_of(child).lower() in _TRUE for child in children(element, tag))


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
    x, y, z, *angles = _numbers(child, 6) if text_of(child) else [0.0] * 6
    roll, pitch, yaw = map(within_a_turn, angles)
    return to_transform(Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw)))


def _numbers(element: Element, count: int) -> tuple[float, ...]:
    return to_numbers(text_of(element), count, element, "its text")


def _sdf_geometry(element: Element) -> Geometry:
    shapes = list(children(element))
    kind = shapes[0].tagName if len(shapes) == 1 else f"{len(shapes)} shapes"
    if kind not in SHAPES:
        raise DescriptionError(
            f"<geometry> holds {kind}; give one of {', '.join(SHAPES)}", locate(element)
        )
    (shape,) = shapes

    def numbers(
        name: str, count: int, default: tuple[float, ...] | None = None
    ) -> tuple[float, ...]:
        if default is not None and only_child(shape, name) is None:
            return default
        return _numbers(required_child(shape, name), count)

    def uri() -> tuple[str, SourceLocation | None]:
        child = required_child(shape, "uri")
        return text_of(child), locate(child)

    return read_geometry(kind, numbers, uri)


def _sdf_colour(link: Element) -> RGBA:
    for visual in children(link, "visual"):
        for tag in ("diffuse", "ambient"):
            colour = _descendant(visual, "material", tag)
            if colour is not None:
                opaque = len(text_of(colour).split()) == 3
                red, green, blue, *alpha = _numbers(colour, 3 if opaque else 4)
                return red, green, blue, alpha[0] if alpha else 1.0
        named = _gazebo_colour(_descendant(visual, "material", "script", "name"))
        if named is not None:
            return named
    return _UNPAINTED
