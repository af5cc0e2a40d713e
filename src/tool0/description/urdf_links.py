"""Reading ``<link>`` and ``<material>``: masses, shapes and colours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from xml.dom.minidom import Element

from tool0.description.attributes import (
    choice,
    number,
    numbers,
    only_child,
    origin,
    positive,
    required,
    required_child,
    vector,
)
from tool0.description.model import Collision, Inertial, Link, Visual
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere, find_mesh
from tool0.description.xml_source import children, locate
from tool0.errors import DescriptionError, ModelError

Rgba = tuple[float, float, float, float]

_SHAPES = ("box", "capsule", "cylinder", "mesh", "sphere")
# The slack of the triangle inequality, for numbers rounded by CAD programs.
_ROUNDING = 1e-3


def read_materials(robot: Element) -> dict[str, Rgba]:
    """Return the colours that ``robot`` defines for all its links."""
    materials: dict[str, Rgba] = {}
    for element in children(robot, "material"):
        rgba = _color(element)
        if rgba is not None:
            materials[required(element, "name")] = rgba
    return materials


def read_link(element: Element, materials: Mapping[str, Rgba]) -> Link:
    """Return the link that ``element`` describes."""
    name = required(element, "name")
    return Link(
        name=name,
        inertial=_read_inertial(element, name),
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


def _read_inertial(link: Element, name: str) -> Inertial | None:
    element = only_child(link, "inertial")
    if element is None:
        return None
    mass_element = required_child(element, "mass")
    mass = number(mass_element, "value")
    if not mass > 0:
        raise ModelError(
            f"link '{name}' has mass {mass:g} kg; give a mass above zero, "
            "or leave <inertial> out for a frame without mass",
            locate(mass_element),
        )
    tensor = required_child(element, "inertia")
    inertial = Inertial(
        mass=mass,
        origin=origin(element),
        ixx=number(tensor, "ixx"),
        ixy=number(tensor, "ixy", 0.0),
        ixz=number(tensor, "ixz", 0.0),
        iyy=number(tensor, "iyy"),
        iyz=number(tensor, "iyz", 0.0),
        izz=number(tensor, "izz"),
    )
    _check_inertia(inertial, name, tensor)
    return inertial


def _check_inertia(inertial: Inertial, name: str, element: Element) -> None:
    """Raise ModelError unless some body of positive mass has this inertia."""
    low, middle, high = principal_moments(inertial)
    moments = f"principal moments {low:.4g}, {middle:.4g}, {high:.4g} kg·m²"
    if not low > 0:
        raise ModelError(
            f"the inertia of link '{name}' is not positive definite ({moments}); "
            "check the signs and the products of inertia",
            locate(element),
        )
    if not low + middle >= high * (1 - _ROUNDING):
        raise ModelError(
            f"no body has the inertia of link '{name}' ({moments}): the largest "
            "must not exceed the sum of the others (triangle inequality); "
            "check the units and the axes",
            locate(element),
        )


def principal_moments(inertial: Inertial) -> tuple[float, float, float]:
    """Return the eigenvalues of the inertia [kg·m²], smallest first.

    In closed form, as https://en.wikipedia.org/wiki/Eigenvalue_algorithm gives it
    for symmetric 3 by 3 matrices: NumPy is slow to import.
    """
    a, b, c = inertial.ixx, inertial.iyy, inertial.izz
    d, e, f = inertial.ixy, inertial.ixz, inertial.iyz
    off = d * d + e * e + f * f
    if off == 0.0:
        low, middle, high = sorted((a, b, c))
        return low, middle, high
    mean = (a + b + c) / 3
    a, b, c = a - mean, b - mean, c - mean
    spread = math.sqrt((a * a + b * b + c * c + 2 * off) / 6)
    determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    cosine = determinant / (2 * spread**3)
    angle = math.acos(min(1.0, max(-1.0, cosine))) / 3
    high = mean + 2 * spread * math.cos(angle)
    low = mean + 2 * spread * math.cos(angle + 2 * math.pi / 3)
    return low, 3 * mean - high - low, high


def _read_geometry(owner: Element) -> Geometry:
    shapes = list(children(required_child(owner, "geometry")))
    if len(shapes) != 1:
        raise DescriptionError(
            f"<geometry> has {len(shapes)} shapes; give one of {', '.join(_SHAPES)}",
            locate(shapes[1] if shapes else required_child(owner, "geometry")),
        )
    (shape,) = shapes
    kind = choice(shape.tagName, _SHAPES, shape, "geometry")
    if kind == "box":
        return Box(size=_box_size(shape))
    if kind == "cylinder":
        return Cylinder(
            radius=positive(shape, "radius"), length=positive(shape, "length")
        )
    if kind == "sphere":
        return Sphere(radius=positive(shape, "radius"))
    if kind == "mesh":
        return _read_mesh(shape)
    raise DescriptionError(
        "<capsule> is read by no engine; write a cylinder and two spheres",
        locate(shape),
    )


def _box_size(shape: Element) -> tuple[float, float, float]:
    size = vector(shape, "size")
    if not min(size) > 0:
        raise DescriptionError(
            f"<box> has size {size}; each edge must be above zero", locate(shape)
        )
    return size


def _read_mesh(shape: Element) -> Mesh:
    uri = required(shape, "filename")
    location = locate(shape)
    path = find_mesh(uri, location)
    scale = vector(shape, "scale", (1.0, 1.0, 1.0))
    if not all(scale):
        raise DescriptionError(f"<mesh> has scale {scale}: never zero", location)
    return Mesh(uri=uri, path=path, scale=scale)


def _read_rgba(visual: Element, materials: Mapping[str, Rgba]) -> Rgba | None:
    element = only_child(visual, "material")
    if element is None:
        return None
    return _color(element) or materials.get(element.getAttribute("name"))


def _color(material: Element) -> Rgba | None:
    element = only_child(material, "color")
    if element is None:
        return None
    red, green, blue, alpha = rgba = numbers(element, "rgba", 4)
    if not (min(rgba) >= 0 and max(rgba) <= 1):
        raise DescriptionError(
            f"<color> has rgba {rgba}; each must be within 0 … 1", locate(element)
        )
    return red, green, blue, alpha
