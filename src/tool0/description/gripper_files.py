"""Checks that a gripper's YAML files must pass before xacro reads them.

Errors state the file and the line.  The checks cover the keys that all grippers have,
regardless of the mechanism that the macro in the folder describes.  If the macro needs
an additional key that is missing, xacro reports the mapping in which it is missing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from tool0.description.model import (
    Inertial,
    JointLimits,
    check_inertia,
    check_mass,
    check_protocol,
)
from tool0.description.yaml_checks import (
    allow_only,
    check_files,
    check_positive,
    check_shape,
    child_at,
    impossible_value,
    mapping_at,
    number_of,
    numbers_at,
    vector_of,
    wrong_value,
)
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import LimitsError

_BOUNDS = ("min_position", "max_position")
_LARGEST = ("max_velocity", "max_effort")
_RANGES = (("min_speed", "max_speed"), ("min_force", "max_force"))
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def check_gripper_files(files: Mapping[str, Path]) -> None:
    """Raise an error, with file and line, for the first missing or impossible value.

    ``files`` maps the names of the gripper's files, such as ``joint_limits``, to their
    paths.

    Raises:
        DescriptionError: If a key is missing or unknown, or a value is not a number.
        ModelError: If a value is physically impossible.
    """
    check_files(files, _CHECKS)


def _check_kinematics(root: YamlEntry) -> None:
    places = mapping_at(root, "kinematics")
    size = places.find("pad_size")
    if size is not None and min(vector_of(size, 3)) <= 0.0:
        raise impossible_value(size, "sizes above zero")
    for place in places.children.values():
        for value in place.children.values():
            number_of(value)


def _check_joints(root: YamlEntry) -> None:
    for name, joint in mapping_at(root, "joint_limits").children.items():
        allow_only(joint, *_BOUNDS, *_LARGEST)
        check_positive(joint, tuple(key for key in _LARGEST if joint.find(key)))
        lower, upper = numbers_at(joint, _BOUNDS, others=True).values()
        try:
            JointLimits(lower=lower, upper=upper)
        except LimitsError as error:
            location = joint.children[_BOUNDS[0]].location
            raise LimitsError(f"joint '{name}': {error.message}", location) from None


def _check_limits(root: YamlEntry) -> None:
    _check_joints(root)
    grip = mapping_at(root, "grip")
    keys = ("max_opening", *_RANGES[0], *_RANGES[1])
    allow_only(grip, "protocol", *keys)
    protocol = grip.find("protocol")
    if protocol is not None and not protocol.is_null:
        if not isinstance(protocol.scalar, str):
            raise wrong_value(protocol, "the name of a protocol")
        check_protocol(protocol.scalar, protocol.location)
    check_positive(grip, keys)
    for low, high in _RANGES:
        least, most = (number_of(grip.children[key]) for key in (low, high))
        if least > most:
            raise impossible_value(grip.children[low], f"at most {high}, {most:g}")


def _check_physical(root: YamlEntry) -> None:
    for name, body in mapping_at(root, "inertia_parameters").children.items():
        mass = numbers_at(body, ("mass",), others=True)["mass"]
        check_mass(mass, name, body.children["mass"].location)
        vector_of(child_at(body, "center_of_mass"), 3)
        tensor = mapping_at(body, "tensor")
        ixx, iyy, izz, ixy, ixz, iyz = numbers_at(tensor, _MOMENTS).values()
        inertial = Inertial(
            mass=mass, ixx=ixx, iyy=iyy, izz=izz, ixy=ixy, ixz=ixz, iyz=iyz
        )
        check_inertia(inertial, name, tensor.location)
    drive = mapping_at(root, "drive")
    check_positive(drive, ("mechanical_reduction",))
    for entry in (drive, root.find("pad_surface")):
        for value in () if entry is None else entry.children.values():
            if not isinstance(value.scalar, bool) and not number_of(value) >= 0.0:
                raise impossible_value(value, "zero or above")


def _check_visuals(root: YamlEntry) -> None:
    materials = mapping_at(root, "materials")
    for material in materials.children.values():
        vector_of(material, 4)
    for shapes in mapping_at(root, "links").children.values():
        allow_only(shapes, "visual", "collision")
        for part, entry in shapes.children.items():
            for item in entry.items:
                check_shape(item, materials if part == "visual" else None)


def _check_poses(root: YamlEntry) -> None:
    for pose in mapping_at(root, "poses").children.values():
        for position in pose.children.values():
            number_of(position)


_CHECKS: Mapping[str, Callable[[YamlEntry], None]] = {
    "kinematics": _check_kinematics,
    "joint_limits": _check_limits,
    "linkage": _check_joints,
    "physical_parameters": _check_physical,
    "visual_parameters": _check_visuals,
    "poses": _check_poses,
}
GRIPPER_FILES: Final = tuple(_CHECKS)
"""Names, without ``.yaml``, of the files that are checked."""
