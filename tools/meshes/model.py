"""What a robot looks like and where it can be touched, link by link."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from .solid import Solid

Vector: TypeAlias = tuple[float, float, float]
ORIGIN: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cylinder:
    """A cylinder around the z axis of its pose."""

    radius: float
    length: float
    xyz: Vector = ORIGIN
    rpy: Vector = ORIGIN


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A box centred on its pose."""

    size: Vector
    xyz: Vector = ORIGIN
    rpy: Vector = ORIGIN


Primitive: TypeAlias = Cylinder | Box


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkShape:
    """One link, in its own frame [m]."""

    visual: Mapping[str, tuple[Solid, ...]]
    """Solids by the name of their material."""
    collision: tuple[Primitive, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelShape:
    """One arm or gripper."""

    name: str
    """The folder of its meshes and parameters."""
    kind: str
    """Where the folder with its parameters is: ``arms`` or ``grippers``."""
    materials: Mapping[str, tuple[float, float, float, float]]
    """Red, green, blue, alpha, each 0 to 1."""
    links: Mapping[str, LinkShape]
