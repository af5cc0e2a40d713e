"""Reading a simple model from URDF: links joined firmly, with one shape in all."""

from __future__ import annotations

from xml.dom.minidom import Document, Element

from tool0.description.attributes import only_child, text_of
from tool0.description.kinematics import to_transform, transforms
from tool0.description.model import Collision, Link, RobotModel
from tool0.description.rigid_model import UNPAINTED, RigidModel, gazebo_colour
from tool0.description.scene import DEFAULT_FRICTION, RGBA
from tool0.description.urdf import read_model
from tool0.description.xml_source import children
from tool0.errors import DescriptionError

_WORLD = "world"
"""The name of a root link that Gazebo takes for the world itself."""


def read_rigid_urdf(document: Document) -> RigidModel:
    """Return the model that a URDF describes.

    Raises:
        DescriptionError: If it cannot be read, or is no single body of one shape.
        ModelError: If nothing could be like this.
    """
    model = read_model(document)
    extensions = _extensions(document)
    if model.movable_joints:
        names = ", ".join(f"'{joint.name}'" for joint in model.movable_joints)
        raise DescriptionError(
            f"model '{model.name}' has joints that move, {names}: only one rigid "
            "body can be spawned; write fixed joints, or leave them out"
        )
    link, shape = _one_shape(model)
    poses = transforms(model)
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
        mass=_mass(model, extensions),
        friction=DEFAULT_FRICTION if mu1 is None else mu1,
        rgba=_colour(model, extensions),
    )


def _one_shape(model: RobotModel) -> tuple[Link, Collision]:
    shapes = [(link, shape) for link in model.links for shape in link.collisions]
    if len(shapes) != 1:
        raise DescriptionError(
            f"model '{model.name}' has {len(shapes)} <collision> shapes; what is "
            "spawned has exactly one"
        )
    return shapes[0]


def _mass(model: RobotModel, extensions: list[Element]) -> float | None:
    """Return the mass of all links [kg]; None of what stands still."""
    if model.root == _WORLD or any(
        text_of(flag).lower() in {"true", "1"}
        for extension in extensions
        for flag in children(extension, "static")
    ):
        return None
    mass = sum(link.inertial.mass for link in model.links if link.inertial is not None)
    if not mass:
        raise DescriptionError(
            f"model '{model.name}' has no mass; give its link an <inertial>, or say "
            "<gazebo><static>true</static></gazebo>"
        )
    return mass


def _colour(model: RobotModel, extensions: list[Element]) -> RGBA:
    """Return the colour for Gazebo if one is named, else the first visual's."""
    for extension in extensions:
        material = only_child(extension, "material")
        named = None if material is None else gazebo_colour(text_of(material))
        if named is not None:
            return named
    visuals = [visual for link in model.links for visual in link.visuals]
    return next((v.rgba for v in visuals if v.rgba is not None), UNPAINTED)


def _extensions(document: Document) -> list[Element]:
    robot = document.documentElement
    return [] if robot is None else list(children(robot, "gazebo"))
