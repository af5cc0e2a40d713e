"""Checks of an arm's YAML files before xacro reads them: errors name file and line.

The built-in arms are checked by the tests, your own files whenever they are loaded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Final

from tool0.description.expansion import read_parameters
from tool0.description.model import Inertial, JointLimits, check_inertia, check_mass
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import (
    DescriptionError,
    LimitsError,
    ModelError,
    did_you_mean,
    nearest_name,
)

LINKS: Final = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
"""The moving links, as the files call them."""
JOINTS: Final = {
    "shoulder_pan": "shoulder_pan_joint",
    "shoulder_lift": "shoulder_lift_joint",
    "elbow_joint": "elbow_joint",
    "wrist_1": "wrist_1_joint",
    "wrist_2": "wrist_2_joint",
    "wrist_3": "wrist_3_joint",
}
"""The joints, as joint_limits.yaml calls them, and their names."""
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
"""The keys of one joint, in ur_description, too."""
_SIZES: Mapping[str, tuple[str, ...]] = {
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
}
_SHAPES = ("mesh", "box", *_SIZES)


def check_arm_files(files: Mapping[str, Path]) -> None:
    """Raise an error with file and line for the first missing or impossible value.

    ``files`` are an arm's by name, such as ``joint_limits``; other names are skipped.

    Raises:
        DescriptionError: If a key is missing or unknown, or a value is no number.
        ModelError: If no arm can have the value.
    """
    for name, check in _CHECKS.items():
        path = files.get(name)
        if path is not None and path.is_file():
            check(read_parameters(path))


def _check_kinematics(root: YamlEntry) -> None:
    kinematics = _mapping(root, "kinematics")
    _only(kinematics, *LINKS, "hash")
    for link in LINKS:
        _numbers(_mapping(kinematics, link), _POSITION + _ROTATION)


def _check_limits(root: YamlEntry) -> None:
    limits = _mapping(root, "joint_limits")
    _only(limits, *JOINTS)
    for joint, name in JOINTS.items():
        entry = _mapping(limits, joint)
        _only(entry, *_LIMITS)
        has_limits = entry.find("has_position_limits")
        if has_limits is not None and not isinstance(has_limits.scalar, bool):
            raise _wrong(has_limits, "true or false")
        is_endless = has_limits is not None and not has_limits.scalar
        bounds = () if is_endless else ("min_position", "max_position")
        values = _numbers(entry, ("max_velocity", "max_effort", *bounds), others=True)
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
    body = _mapping(root, "inertia_parameters")
    for link in (_BASE, *LINKS):
        mass = _child(body, f"{link}_mass", _MASSES)
        name = "base_link_inertia" if link == _BASE else f"{link}_link"
        check_mass(_number(mass), name, mass.location)
        if link in body.children.get("tensor", body).children:
            tensor = _mapping(_mapping(body, "tensor"), link)
            centre = _mapping(_mapping(body, "center_of_mass"), f"{link}_cog")
            _numbers(centre, _POSITION)
            _numbers(_mapping(_mapping(body, "rotation"), link), _ROTATION)
            ixx, iyy, izz, ixy, ixz, iyz = _numbers(tensor, _MOMENTS).values()
            inertial = Inertial(
                mass=_number(mass), ixx=ixx, iyy=iyy, izz=izz, ixy=ixy, ixz=ixz, iyz=iyz
            )
            check_inertia(inertial, name, tensor.location)
        else:
            _sizes(_mapping(_mapping(body, "links"), link), ("radius", "length"))


def _check_visuals(root: YamlEntry) -> None:
    if "mesh_files" in root.children:  # the layout of ur_description
        return
    materials, links = _mapping(root, "materials"), _mapping(root, "links")
    for material in materials.children.values():
        _vector(material, 4)
    _only(links, _BASE, *LINKS)
    for link in (_BASE, *LINKS):
        shapes = _mapping(links, link)
        _only(shapes, "visual", "collision")
        for part, entry in shapes.children.items():
            if not entry.is_list:
                raise _wrong(entry, "a list of shapes")
            for item in entry.items:
                _check_shape(item, materials if part == "visual" else None)


def _check_shape(item: YamlEntry, materials: YamlEntry | None) -> None:
    kind = next(iter(item.children), "")
    if kind not in _SHAPES:
        raise DescriptionError(
            f"a shape begins with {', '.join(_SHAPES[:-1])} or {_SHAPES[-1]}, "
            f"got {kind or item.describe()!r}{did_you_mean(kind, _SHAPES)}",
            item.location,
        )
    _only(item, kind, "xyz", "rpy", "scale", "material")
    shape = item.children[kind]
    if kind == "box":
        size = _child(shape, "size")
        if min(_vector(size, 3)) <= 0.0:
            raise _impossible(size, "sizes above zero")
    elif kind == "mesh":
        if not isinstance(shape.scalar, str):
            raise _wrong(shape, "the path of a mesh")
    else:
        _sizes(_mapping(item, kind), _SIZES[kind])
    for key in ("xyz", "rpy"):
        if (pose := item.find(key)) is not None:
            _vector(pose, 3)
    if materials is not None:
        material = _child(item, "material")
        if material.scalar not in materials.children:
            hint = did_you_mean(str(material.scalar), materials.children)
            raise DescriptionError(
                f"unknown material '{material.scalar}'{hint}", material.location
            )


def _check_poses(root: YamlEntry) -> None:
    for pose in _mapping(root, "poses").children.values():
        _only(pose, *JOINTS.values())
        for position in pose.children.values():
            _number(position)


def _check_specifications(root: YamlEntry) -> None:
    _sizes(_mapping(root, "specifications"), ("payload", "reach"))


_CHECKS: Mapping[str, Callable[[YamlEntry], None]] = {
    "default_kinematics": _check_kinematics,
    "joint_limits": _check_limits,
    "physical_parameters": _check_physical,
    "visual_parameters": _check_visuals,
    "poses": _check_poses,
    "specifications": _check_specifications,
}
ARM_FILES: Final = tuple(_CHECKS)
"""The names of the files that are checked, without ``.yaml``."""


def _child(entry: YamlEntry, key: str, siblings: Collection[str] = ()) -> YamlEntry:
    """Return the entry at ``key``, which ``siblings`` are not mistaken for."""
    child = entry.find(key)
    if child is None:
        near = nearest_name(key, entry.children.keys() - set(siblings))
        hint = f"; did you mean '{near}'?" if near else ""
        name = f"'{_dotted(entry)}' has" if entry.key else "the file has"
        raise DescriptionError(f"{name} no key '{key}'{hint}", entry.location)
    return child


def _mapping(entry: YamlEntry, key: str) -> YamlEntry:
    child = _child(entry, key)
    if not child.is_mapping:
        raise _wrong(child, "a mapping")
    return child


def _only(entry: YamlEntry, *valid: str) -> None:
    for key, child in entry.children.items():
        if key not in valid:
            raise DescriptionError(
                f"unknown key '{_dotted(child)}'{did_you_mean(key, valid)}",
                child.location,
            )


def _numbers(
    entry: YamlEntry, keys: tuple[str, ...], *, others: bool = False
) -> dict[str, float]:
    """Return the numbers at ``keys``; unless ``others``, there are no other keys."""
    if not others:
        _only(entry, *keys)
    return {key: _number(_child(entry, key, keys)) for key in keys}


def _sizes(entry: YamlEntry, keys: tuple[str, ...]) -> None:
    for key, value in _numbers(entry, keys, others=True).items():
        if not value > 0.0:
            raise _impossible(entry.children[key], "above zero")


def _vector(entry: YamlEntry, count: int) -> list[float]:
    if len(entry.items) != count:
        raise _wrong(entry, f"a list of {count} numbers")
    return [_number(item) for item in entry.items]


def _number(entry: YamlEntry) -> float:
    """Return a finite number; YAML 1.1 takes some, such as 2e-05, for text."""
    value = entry.scalar
    try:
        number = math.nan if value is None or value is True else float(value)
    except ValueError:
        raise _wrong(entry, "a number") from None
    if value is False or not math.isfinite(number):
        raise _wrong(entry, "a finite number")
    return number


def _dotted(entry: YamlEntry) -> str:
    return entry.key.replace("/", ".")


def _wrong(entry: YamlEntry, wanted: str) -> DescriptionError:
    return DescriptionError(
        f"'{_dotted(entry)}' must be {wanted}, got {entry.describe()}", entry.location
    )


def _impossible(entry: YamlEntry, wanted: str) -> ModelError:
    return ModelError(
        f"'{_dotted(entry)}' must be {wanted}, got {entry.plain()}", entry.location
    )
