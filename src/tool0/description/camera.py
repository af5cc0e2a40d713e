"""Cameras as immutable values: pose and projection."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, final

from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.parts import base_of, find_arms, flange_names
from tool0.description.transform import (
    Pose,
    Transform,
    Vector3,
    cross,
    to_pose,
    to_transform,
)
from tool0.description.units import ANGLE
from tool0.errors import ConfigError, ModelError, SourceLocation

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

LARGEST = 4096
"""Largest width and height [pixels] that every OpenGL implementation supports."""

_SCENE_VIEW = math.radians(50.0)
_ARM_LENGTH = 1.098
"""Sum of the joint-to-joint distances [m] of the arm for which ``_WORKSPACE`` and
``_VIEWPOINT`` are defined."""
_WORKSPACE: Vector3 = (0.35, 0.05, 0.15)
"""Point at which the scene camera looks, in the arm's base frame [m]."""
_VIEWPOINT: Vector3 = (1.0, -1.0, 0.7)
"""Position of the scene camera relative to ``_WORKSPACE`` [m]."""
_NAME = re.compile(r"[A-Za-z]\w*")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """A pinhole camera without distortion; its pixels are square.

    The camera's frame is an optical frame (REP-103): z points forward, and in the image
    x points right and y points down.
    """

    name: str
    """Name of the camera, and prefix of the camera's ROS topics and frames."""
    link: str | None = None
    """Link that carries the camera; None means the robot's root."""
    pose: Pose = field(default_factory=Pose)
    """Pose of the optical frame in the link."""
    width: int = 640
    """Width of the image [pixels]."""
    height: int = 480
    """Height of the image [pixels]."""
    field_of_view: float = math.radians(45.0)
    """Vertical field of view [rad]."""
    near: float = 0.01
    """Depth below which points are invisible [m]."""
    far: float = 10.0
    """Depth beyond which points are invisible [m]."""
    location: SourceLocation | None = field(default=None, compare=False, repr=False)
    """Location of the camera in the user's file, for error messages."""

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ConfigError(
                f"'{self.name}' cannot name a camera; use letters, digits and '_', "
                "a letter first: ROS topics start with it"
            )
        of = f"of camera '{self.name}'"
        if not all(map(math.isfinite, (*self.pose.xyz, *self.pose.rpy))):
            raise ConfigError(f"the pose {of} must be finite, got {self.pose}")
        for what, pixels in (("width", self.width), ("height", self.height)):
            if not (isinstance(pixels, int) and 1 <= pixels <= LARGEST):
                raise ConfigError(
                    f"the {what} {of} must be 1 … {LARGEST} pixels, got {pixels}"
                )
        if not 0.0 < self.field_of_view < math.pi:
            raise ConfigError(
                f"the field of view {of} must be above 0 and below pi rad, "
                f"got {self.field_of_view:g}"
                + ANGLE.suggestion(self.field_of_view, lambda meant: meant < math.pi)
            )
        if not 0.0 < self.near < self.far < math.inf:
            raise ConfigError(
                f"camera '{self.name}' needs 0 < near < far in metres, "
                f"got near {self.near:g} and far {self.far:g}"
            )

    @property
    def focal_length(self) -> float:
        """Focal length [pixels], the same in both directions."""
        return self.height / (2.0 * math.tan(self.field_of_view / 2.0))

    @property
    def intrinsics(self) -> NDArray[np.float64]:
        """``K``, shape (3, 3): ``K @ p_optical`` is ``z * (u, v, 1)`` in pixels.

        The center of the top left pixel is (0, 0), as in ROS and OpenCV.  The
        center of the image is ((width - 1) / 2, (height - 1) / 2).
        """
        import numpy as np

        f = self.focal_length
        cx, cy = (self.width - 1) / 2.0, (self.height - 1) / 2.0
        return np.array([[f, 0.0, cx], [0.0, f, cy], [0.0, 0.0, 1.0]])

    @property
    def T_link_camera(self) -> Transform:
        """Pose of the optical frame in the link."""
        return to_transform(self.pose)

    def check_on(self, model: RobotModel) -> None:
        """Raise ConfigError if the robot does not have the link of the camera."""
        if self.link is None:
            return
        try:
            model.link(self.link)
        except ModelError as error:
            raise ConfigError(
                f"camera '{self.name}': {error.message}", self.location
            ) from None


def looking(
    position: Sequence[float],
    at: Sequence[float],
    up: Sequence[float] = (0.0, 0.0, 1.0),
) -> Pose:
    """Return the pose of a camera at ``position`` [m] that looks at ``at`` [m].

    The point ``at`` is at the center of the image, and ``up`` points upwards in the
    image.

    Raises:
        ConfigError: If the points coincide, or ``up`` is parallel to the viewing
            direction.
    """
    (x, y, z), (ux, uy, uz) = position, up
    forward = _unit(tuple(b - a for a, b in zip(position, at, strict=True)))
    right = _unit(cross(forward, (ux, uy, uz))) if forward else None
    if forward is None or right is None:
        raise ConfigError(
            f"a camera at {tuple(position)} cannot look at {tuple(at)} with "
            f"{tuple(up)} up; move it, or change up"
        )
    down = cross(forward, right)
    a, b, c = zip(right, down, forward, strict=True)
    return to_pose(Transform(position=(x, y, z), rotation=(a, b, c)))


def default_cameras(model: RobotModel) -> tuple[Camera, ...]:
    """Return a camera on each flange, and the camera ``scene``, which shows all arms.

    If the robot has one flange, its camera is called ``wrist``.  If the robot has
    several flanges, the names of the cameras start with the flanges' prefixes, as in
    ``left_wrist``.
    """
    flanges = flange_names(model)
    cameras = [
        # The camera is beside the gripper's body, in the plane between the fingers,
        # like a depth camera on a bracket.  The fingertips are in the lower part of the
        # image.  The field of view is that of the depth image of a RealSense D435 (87°
        # x 58°, https://www.intelrealsense.com/depth-camera-d435/).
        Camera(
            name="wrist" if len(flanges) == 1 else f"{name}_wrist",
            link=flange,
            pose=looking((-0.075, 0.0, 0.05), (0.0, 0.0, 0.25), up=(-1.0, 0.0, 0.0)),
            field_of_view=math.radians(58.0),
            far=5.0,
        )
        for name, flange in flanges.items()
    ]
    position, at = _view_of_all(model)
    scene = Camera(
        name="scene",
        pose=looking(position, at),
        field_of_view=_SCENE_VIEW,
        far=max(20.0, 4.0 * math.dist(position, at)),
    )
    return (*cameras, scene)


def _view_of_all(model: RobotModel) -> tuple[Vector3, Vector3]:
    """Return a viewpoint from which all arms are visible, and a target point [m]."""
    poses = link_poses(model)
    views = []
    for name, arm in find_arms(model).items():
        length = sum(math.hypot(*joint.origin.xyz) for joint in arm.joints)
        scale = round(length / _ARM_LENGTH, 2)
        # The x axis of the frame of a UR's first joint points backwards.
        T_root_base = Transform(
            position=poses[arm.joints[0].parent].position,
            rotation=poses[base_of(model, name)].rotation,
        )
        x, y, z = (value * scale for value in _WORKSPACE)
        views.append((T_root_base.apply((x, y, z)), scale))
    if not views:
        views = [(_WORKSPACE, 1.0)]
    points = [point for point, _ in views]
    x, y, z = (sum(values) / len(points) for values in zip(*points, strict=True))
    spread = max(math.dist(point, (x, y, z)) for point in points)
    # Move the camera back until the row of arms fits into a 4:3 image.
    back = max(scale for _, scale in views)
    back += 0.75 * spread / math.tan(_SCENE_VIEW / 2.0) / math.hypot(*_VIEWPOINT)
    dx, dy, dz = (value * back for value in _VIEWPOINT)
    return (x + dx, y + dy, z + dz), (x, y, z)


def merged(*groups: Iterable[Camera]) -> dict[str, Camera]:
    """Return cameras by name; later groups take precedence over earlier groups.

    Raises:
        ConfigError: If a camera name occurs twice in one group.
    """
    found: dict[str, Camera] = {}
    for group in groups:
        names: set[str] = set()
        for camera in group:
            if camera.name in names:
                raise ConfigError(f"two cameras are called '{camera.name}'; rename one")
            names.add(camera.name)
            found[camera.name] = camera
    return found


def _unit(vector: Sequence[float]) -> Vector3 | None:
    length = math.hypot(*vector)
    if not 1e-9 < length < math.inf:
        return None
    x, y, z = (part / length for part in vector)
    return x, y, z
