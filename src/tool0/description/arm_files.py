"""Checks that an arm's YAML files must pass before xacro reads them.

Errors state the file and the line.  The files of the built-in arms are checked by the
tests.  Your own files are checked each time they are loaded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from tool0.description.model import Inertial, JointLimits, check_inertia, check_mass
from tool0.description.yaml_checks import (
    allow_only,
    check_files,
    check_positive,
    check_shape,
    child_at,
    mapping_at,
    number_of,
    numbers_at,
    vector_of,
    wrong_value,
)
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import LimitsError

LINKS: Final = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
"""Names of the moving links in an arm's YAML files."""
JOINTS: Final = {
    "shoulder_pan": "shoulder_pan_joint",
    "shoulder_lift": "shoulder_lift_joint",
    "elbow_joint": "elbow_joint",
    "wrist_1": "wrist_1_joint",
    "wrist_2": "wrist_2_joint",
    "wrist_3": "wrist_3_joint",
}
"""Joint names in joint_limits.yaml → joint names in the URDF."""
_BASE = "base"
_MASSES = tuple(f"{link}_mass" for link in (_BASE, *LINKS))
_POSITION, _ROTATION = ("x", "y", "z"), ("roll", "pitch", "yaw")
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_QUANTITIES = ("position", "velocity", "acceleration", "deceleration", "jerk", "effort")
_LIMITS = tuple(
    [f"has_{name}_limits" for name in _QUANTITIES]
    + ["has_soft_limits", "min_position"]
    + [f"max_{name}" for name in _QUANTITIES]
)
"""Keys that are valid for a joint, including the keys in ur_description's files."""


def check_arm_files(files: Mapping[str, Path]) -> None:
    """Raise an error, with file and line, for the first missing or impossible value.

    ``files`` maps the names of the arm's files, such as ``joint_limits``, to their
    paths.  Files without a check are skipped.

    Raises:
        DescriptionError: If a key is missing or unknown, or a value is not a number.
        ModelError: If a value is physically impossible.
    """
    check_files(files, _CHECKS)


def _check_kinematics(root: YamlEntry) -> None:
    kinematics = mapping_at(root, "kinematics")
    allow_only(kinematics, *LINKS, "hash")
    for link in LINKS:
        numbers_at(mapping_at(kinematics, link), _POSITION + _ROTATION)


def _check_limits(root: YamlEntry) -> None:
    limits = mapping_at(root, "joint_limits")
    allow_only(limits, *JOINTS)
    for joint, name in JOINTS.items():
        entry = mapping_at(limits, joint)
        allow_only(entry, *_LIMITS)
        has_limits = entry.find("has_position_limits")
        if has_limits is not None and not isinstance(has_limits.scalar, bool):
            raise wrong_value(has_limits, "true or false")
        is_endless = has_limits is not None and not has_limits.scalar
        bounds = () if is_endless else ("min_position", "max_position")
        values = numbers_at(entry, ("max_velocity", "max_effort", *bounds), others=True)
        try:
            JointLimits(
                lower=values.get("min_position", -math.inf),
                upper=values.get("max_position", math.inf),
                velocity=values["max_velocity"],
                effort=values["max_effort"],
            )
        except LimitsError as error:
            wrong = next(
                (key for key in ("max_velocity", "max_effort") if values[key] <= 0.0),
                "min_position",
            )
            message = f"joint '{name}': {error.message}"
            raise LimitsError(message, entry.children[wrong].location) from None


def _check_physical(root: YamlEntry) -> None:
    body = mapping_at(root, "inertia_parameters")
    for link in (_BASE, *LINKS):
        mass = child_at(body, f"{link}_mass", _MASSES)
        name = "base_link_inertia" if link == _BASE else f"{link}_link"
        check_mass(number_of(mass), name, mass.location)
        if link in body.children.get("tensor", body).children:
            tensor = mapping_at(mapping_at(body, "tensor"), link)
            centre = mapping_at(mapping_at(body, "center_of_mass"), f"{link}_cog")
            numbers_at(centre, _POSITION)
            numbers_at(mapping_at(mapping_at(body, "rotation"), link), _ROTATION)
            ixx, iyy, izz, ixy, ixz, iyz = numbers_at(tensor, _MOMENTS).values()
            inertial = Inertial(
                mass=number_of(mass),
                ixx=ixx,
                iyy=iyy,
                izz=izz,
                ixy=ixy,
                ixz=ixz,
                iyz=iyz,
            )
            check_inertia(inertial, name, tensor.location)
        else:
            check_positive(
                mapping_at(mapping_at(body, "links"), link), ("radius", "length")
            )


def _check_visuals(root: YamlEntry) -> None:
    if "mesh_files" in root.children:  # the layout of ur_description
        return
    materials, links = mapping_at(root, "materials"), mapping_at(root, "links")
    for material in materials.children.values():
        vector_of(material, 4)
    allow_only(links, _BASE, *LINKS)
    for link in (_BASE, *LINKS):
        shapes = mapping_at(links, link)
        allow_only(shapes, "visual", "collision")
        for part, entry in shapes.children.items():
            if not entry.is_list:
                raise wrong_value(entry, "a list of shapes")
            for item in entry.items:
                check_shape(item, materials if part == "visual" else None)


def _check_poses(root: YamlEntry) -> None:
    for pose in mapping_at(root, "poses").children.values():
        allow_only(pose, *JOINTS.values())
        for position in pose.children.values():
            number_of(position)


def _check_specifications(root: YamlEntry) -> None:
    facts = mapping_at(root, "specifications")
    check_positive(facts, ("payload", "reach"))
    if "update_rate" in facts.children:
        check_positive(facts, ("update_rate",))


_CHECKS: Mapping[str, Callable[[YamlEntry], None]] = {
    "default_kinematics": _check_kinematics,
    "joint_limits": _check_limits,
    "physical_parameters": _check_physical,
    "visual_parameters": _check_visuals,
    "poses": _check_poses,
    "specifications": _check_specifications,
}
ARM_FILES: Final = tuple(_CHECKS)
"""Names, without ``.yaml``, of the files that are checked."""
