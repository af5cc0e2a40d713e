"""The objects around the robot, as immutable values."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import final

from tool0.description.camera import Camera
from tool0.description.finding import Finding
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.shapes import RGBA, Box, Solid, check_solid
from tool0.description.transform import Pose, Vector3, to_transform
from tool0.description.units import FAR, require_plausible_size
from tool0.errors import ConfigError, SourceLocation

DEFAULT_FRICTION = 1.0
LONGEST_MODEL = 1_000_000
"""Largest length of a model's text [characters].  One body's text is much shorter, and
a text of this length can be parsed within one second."""
DEFAULT_RGBA: RGBA = (0.90, 0.60, 0.00, 1.0)
"""Orange, a color that is not used by any bundled robot."""

GROUND = "ground"
"""Name of the ground plane in contacts and warnings."""

STILL_RGBA: RGBA = (0.78, 0.74, 0.66, 1.0)
"""Default color of fixed objects, which resembles pale wood."""
PALETTE: tuple[RGBA, ...] = (
    (0.90, 0.60, 0.00, 1.0),  # orange
    (0.00, 0.62, 0.45, 1.0),  # bluish green
    (0.80, 0.47, 0.65, 1.0),  # reddish purple
    (0.94, 0.89, 0.26, 1.0),  # yellow
    (0.84, 0.37, 0.00, 1.0),  # vermilion
    (0.00, 0.45, 0.70, 1.0),  # blue
)
"""Default colors of movable objects, which are assigned in this order.  Color-blind
people can distinguish these colors (Okabe and Ito,
https://jfly.uni-koeln.de/color/)."""

DEFAULT_WALL = 0.004
"""Default thickness of the floor and walls of a bin [m].  The value is that of a common
plastic box."""

_NAME = re.compile(r"[\w.\-]+( [\w.\-]+)*")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SceneObject:
    """A rigid object of uniform density with one or more shapes.

    The friction coefficient between two objects is the smaller of their coefficients,
    as in ODE.  The ground and the robot's links have high friction coefficients.  The
    coefficient of the gripper's pads is stated in the gripper's description.
    """

    name: str
    """Unique name that consists of letters, digits, ``_``, ``-``, ``.`` and single
    spaces."""
    geometry: Solid
    """Shape, centered at the object's origin.  A mesh keeps the origin that its file
    defines, and the convex hull of the mesh is used for collisions.  The parts of a
    compound have poses in the object's frame."""
    pose: Pose = field(default_factory=Pose)
    """Pose of the object in the robot's root, at the start and after a reset."""
    mass: float | None = None
    """Mass of the object [kg]; None for a fixed object."""
    friction: float = DEFAULT_FRICTION
    """Coulomb friction coefficient, with the meaning of Gazebo's ``mu1``."""
    rgba: RGBA = DEFAULT_RGBA
    """Red, green, blue and opacity, each from 0 to 1."""

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ConfigError(
                f"'{self.name}' cannot name an object; "
                "use letters, digits, '_', '-', '.' and single spaces"
            )
        of = f"of object '{self.name}'"
        check_solid(self.geometry, of, is_fixed=self.mass is None)
        if not all(map(math.isfinite, (*self.pose.xyz, *self.pose.rpy))):
            raise ConfigError(f"the pose {of} must be finite, got {self.pose}")
        if self.mass is not None and not 0.0 < self.mass < math.inf:
            raise ConfigError(
                f"the mass {of} must be above 0 kg and finite, got {self.mass:g}; "
                "omit it for a fixed object"
            )
        if not 0.0 <= self.friction < math.inf:
            raise ConfigError(
                f"the friction {of} must be 0 or more and finite, got {self.friction:g}"
            )
        if len(self.rgba) != 4 or not all(0.0 <= part <= 1.0 for part in self.rgba):
            raise ConfigError(
                f"the rgba {of} must be four numbers within 0 … 1, got {self.rgba}"
            )


@final
@dataclass(frozen=True, slots=True)
class Scene:
    """Objects and cameras around the robot."""

    objects: tuple[SceneObject, ...] = ()
    """Objects of the scene.  Each object has a unique name.  Lists of object poses are
    in the same order as this tuple."""
    locations: dict[str, SourceLocation] = field(
        default_factory=dict, compare=False, repr=False
    )
    """Source location of each object by name, for error messages."""
    cameras: tuple[Camera, ...] = ()
    """Cameras in addition to the default cameras of every robot."""

    def __post_init__(self) -> None:
        seen: set[str] = set()
        for item in self.objects:
            if item.name in seen:
                raise ConfigError(
                    f"two objects are called '{item.name}'; rename one",
                    self.locations.get(item.name),
                )
            seen.add(item.name)

    def far_objects(self, model: RobotModel) -> tuple[Finding, ...]:
        """Return a warning for each object that is far from every link."""
        places = [pose.position for pose in link_poses(model).values()]
        found = []
        for item in self.objects:
            distance = min(math.dist(item.pose.xyz, place) for place in places)
            if distance < FAR:
                continue
            found.append(
                Finding(
                    location=self.locations.get(item.name, SourceLocation(None)),
                    rule="far-object",
                    severity="warning",
                    key=item.name,
                    message=f"the object is {distance:g} m from the robot",
                    remedy="positions are in metres; write 400mm or 0.4",
                )
            )
        return tuple(found)

    def check_beside(self, model: RobotModel) -> None:
        """Raise ConfigError if an object has the same name as a link or the ground."""
        taken = {**dict.fromkeys(model.link_by_name, "a link"), GROUND: "the ground"}
        for item in self.objects:
            if item.name in taken:
                raise ConfigError(
                    f"object '{item.name}' has the name of {taken[item.name]}; "
                    "rename it",
                    self.locations.get(item.name),
                )


def bin_walls(
    name: str,
    *,
    size: Sequence[float],
    wall: float = DEFAULT_WALL,
    pose: Pose | None = None,
    friction: float = DEFAULT_FRICTION,
    rgba: RGBA = STILL_RGBA,
) -> tuple[SceneObject, ...]:
    """Return the floor and walls of a bin that is open at the top.

    Args:
        name: Prefix of the names of the five objects: ``name.floor``, ``name.front``
            (+x), ``name.back``, ``name.left`` (+y) and ``name.right``.
        size: Outer dimensions x, y, z [m].
        wall: Thickness of the floor and the walls [m].
        pose: Pose of the center of the outer box, in the robot's root.
        friction: Friction coefficient of all five objects.
        rgba: Color of all five objects.

    Raises:
        ConfigError: If there is no space between the walls, or a value is invalid.
    """
    x, y, z = size
    require_plausible_size((x, y, z), f"bin '{name}'", is_fixed=True)
    if not 0.0 < 2 * wall < min(x, y) or not wall < z:
        raise ConfigError(
            f"the walls of bin '{name}' must be above 0 m and leave room inside, "
            f"got wall {wall:g} for size {x:g}, {y:g}, {z:g}"
        )
    high, up = z - wall, wall / 2
    parts: dict[str, tuple[Vector3, Vector3]] = {
        "floor": ((x, y, wall), (0.0, 0.0, -high / 2)),
        "front": ((wall, y, high), ((x - wall) / 2, 0.0, up)),
        "back": ((wall, y, high), ((wall - x) / 2, 0.0, up)),
        "left": ((x - 2 * wall, wall, high), (0.0, (y - wall) / 2, up)),
        "right": ((x - 2 * wall, wall, high), (0.0, (wall - y) / 2, up)),
    }
    pose = pose or Pose()
    T_root_bin = to_transform(pose)
    return tuple(
        SceneObject(
            name=f"{name}.{part}",
            geometry=Box(size=edges),
            pose=Pose(xyz=T_root_bin.apply(centre), rpy=pose.rpy),
            friction=friction,
            rgba=rgba,
        )
        for part, (edges, centre) in parts.items()
    )
