"""The robot's description, URDF and meshes for pages."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, cast, final

from tool0.description.camera import Camera
from tool0.description.loading import part_names
from tool0.description.model import (
    FLANGE,
    Joint,
    JointLimits,
    JointType,
    LinearOpening,
    ParallelGripper,
    RobotModel,
    RotaryOpening,
)
from tool0.description.parts import (
    base_of,
    find_arms,
    find_grippers,
    gripper_of,
    joints_of,
)
from tool0.description.poses import PoseStore
from tool0.description.robot import RobotDescription
from tool0.description.scene import SceneObject
from tool0.description.shapes import (
    Box,
    Compound,
    Cylinder,
    Geometry,
    Mesh,
    Solid,
    Sphere,
    placed_geometries,
)
from tool0.description.xml_source import parse_text, to_text
from tool0.errors import ConfigError
from tool0.panel.protocol import (
    CameraInfo,
    GripperInfo,
    JointInfo,
    PartInfo,
    PoseInfo,
    RobotInfo,
    RobotPartsInfo,
    ShapeInfo,
    ViewObject,
)

if TYPE_CHECKING:
    from xml.dom.minidom import Document, Element

URDF_PATH = "/robot.urdf"
ONE_AXIS = frozenset({JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC})


@final
class RobotFiles:
    """The URDF and the meshes that a page can request.

    Only files that the model and the scene refer to are served.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._description = description
        geometries: list[Geometry] = []
        for link in description.model.links:
            geometries += [shape.geometry for shape in link.visuals]
            geometries += [shape.geometry for shape in link.collisions]
        meshes = [item for item in geometries if isinstance(item, Mesh)]
        self._numbers = itertools.count()
        self.known: set[Path] = set()
        """Paths of all meshes that the model and the scene have contained."""
        self._url_of = self._urls(meshes, {})
        self._url_of_uri = {mesh.uri: self._url_of[mesh.path] for mesh in meshes}
        self._url_of_object: Mapping[Path, str] = {}

    def set_objects(self, objects: Sequence[SceneObject]) -> None:
        """Serve only the meshes of these objects.

        A mesh that is removed and added again is served at another path, because its
        file may have changed.
        """
        geometries = [
            part for item in objects for part, _ in placed_geometries(item.geometry)
        ]
        meshes = [item for item in geometries if isinstance(item, Mesh)]
        self._url_of_object = self._urls(meshes, self._url_of_object)

    @property
    def meshes(self) -> Mapping[str, Path]:
        """Mesh files by path on the server."""
        both = (self._url_of, self._url_of_object)
        return {url: file for urls in both for file, url in urls.items()}

    def url(self, mesh: Mesh) -> str:
        """Return the path of an object's mesh on the server."""
        return self._url_of_object[mesh.path]

    def _urls(
        self, meshes: Sequence[Mesh], known: Mapping[Path, str]
    ) -> Mapping[Path, str]:
        self.known.update(mesh.path for mesh in meshes)
        return {
            file: known.get(file)
            or f"/meshes/{next(self._numbers)}{file.suffix.lower()}"
            for file in dict.fromkeys(mesh.path for mesh in meshes)
        }

    @cached_property
    def urdf(self) -> bytes:
        """The URDF with server paths instead of file names."""
        document: Document = parse_text(self._description.urdf)
        for element in document.getElementsByTagName("mesh"):
            uri = element.getAttribute("filename")
            element.setAttribute("filename", self._url_of_uri.get(uri, ""))
        for element in list(document.getElementsByTagName("texture")):
            # Textures are not served.
            cast("Element", element.parentNode).removeChild(element)
        return to_text(document).encode()


def robot_info(
    description: RobotDescription,
    joints: Sequence[str],
    ground: float | None,
    limits: Mapping[str, JointLimits],
) -> RobotInfo:
    """Return the data that a page needs to draw the robot.

    ``joints`` are in the order of a frame's arrays, ``ground`` is the height of the
    ground in the robot's root frame [m], and ``limits`` are the limits that differ from
    those in the URDF.
    """
    model = description.model
    titles = {robot.prefix: robot.parts_title for robot in description.robots}
    return RobotInfo(
        name=model.name,
        title=description.title,
        root=model.root,
        urdf=URDF_PATH,
        ground=ground,
        joints=[
            _joint_info(model, model.joint(name), limits.get(name)) for name in joints
        ],
        grippers=[
            _gripper_info(name, gripper)
            for name, gripper in find_grippers(model).items()
        ],
        robots=[
            RobotPartsInfo(
                name=name,
                title=titles.get(arm.flange.removesuffix(FLANGE)),
                prefix=arm.flange.removesuffix(FLANGE),
                base=base_of(model, name),
                joints=list(joints_of(model, name)),
                gripper=gripper_of(model, name),
                tip=arm.flange,
            )
            for name, arm in find_arms(model).items()
        ],
        part_names=dict(part_names(description)),
    )


def camera_infos(cameras: Iterable[Camera]) -> list[CameraInfo]:
    """Return the data that a page needs to request camera images."""
    return [
        CameraInfo(
            name=camera.name, width=camera.width, height=camera.height, far=camera.far
        )
        for camera in cameras
    ]


def object_info(item: SceneObject, files: RobotFiles) -> ViewObject:
    """Return the data that a page needs to draw an object of the scene."""
    return ViewObject(
        name=item.name,
        shape=_shape_info(item.geometry, files),
        rgba=item.rgba,
        mass=item.mass,
        friction=item.friction,
    )


def pose_infos(book: PoseStore, report: Callable[[str], None]) -> list[PoseInfo]:
    """Return all poses; call ``report`` if the saved poses cannot be read."""
    try:
        poses = book.all()
    except ConfigError as error:
        report(str(error))
        poses = book.own
    return [
        PoseInfo(
            name=pose.name,
            saved=pose.saved,
            is_gripper=book.is_of_grippers(pose),
            positions=book.moved(pose),
        )
        for pose in poses.values()
    ]


def _joint_info(
    model: RobotModel, joint: Joint, limits: JointLimits | None
) -> JointInfo:
    limits = limits or joint.limits
    turns_on = joint.type is JointType.CONTINUOUS
    return JointInfo(
        name=joint.name,
        # Engines and the view do not support joints of other types.
        type=cast(Literal["revolute", "continuous", "prismatic"], joint.type.value),
        lower=None if turns_on else _finite(limits.lower),
        upper=None if turns_on else _finite(limits.upper),
        velocity=_finite(limits.velocity),
        effort=_finite(limits.effort),
        driven=joint.name in model.transmission_by_joint,
        mimics=None if joint.mimic is None else joint.mimic.joint,
    )


def _gripper_info(name: str, gripper: ParallelGripper) -> GripperInfo:
    law = gripper.law
    pad_cos = pad_sin = pad_slope = 0.0
    match law:
        case RotaryOpening():
            pad_cos, pad_sin = law.pad_cos, law.pad_sin
        case LinearOpening():
            pad_slope = law.pad_slope
    return GripperInfo(
        name=name,
        joint=gripper.joint,
        max_opening=gripper.max_opening,
        min_speed=gripper.speed[0],
        max_speed=gripper.speed[1],
        min_force=gripper.force[0],
        max_force=gripper.force[1],
        pad_offset=law.pad_offset,
        pad_cos=pad_cos,
        pad_sin=pad_sin,
        pad_slope=pad_slope,
    )


def _shape_info(solid: Solid, files: RobotFiles) -> ShapeInfo:
    match solid:
        case Box(size=size):
            return ShapeInfo(kind="box", size=size)
        case Cylinder(radius=radius, length=length):
            return ShapeInfo(kind="cylinder", radius=radius, length=length)
        case Sphere(radius=radius):
            return ShapeInfo(kind="sphere", radius=radius)
        case Mesh(scale=scale, path=path):
            url = files.url(solid)
            return ShapeInfo(kind="mesh", size=scale, url=url, file=str(path))
        case Compound(parts=parts):
            infos = [
                PartInfo(shape=_shape_info(part, files), xyz=pose.xyz, rpy=pose.rpy)
                for part, pose in parts
            ]
            return ShapeInfo(kind="compound", parts=infos)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
