"""The robots that tool0 brings, and the one door to any robot: a description.

What there is follows from the folders in ``tool0_description/config``: an arm has
``default_kinematics.yaml``, a gripper has ``kinematics.yaml``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, final

from tool0.description.expansion import expand
from tool0.description.model import RobotModel
from tool0.description.packages import find_package
from tool0.description.presets import (
    PartName,
    Poses,
    read_controllers,
    read_part_names,
    read_poses,
)
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_file, to_text
from tool0.errors import DescriptionError, SourceLocation, did_you_mean

if TYPE_CHECKING:
    from xml.dom.minidom import Document

NO_GRIPPER = "none"
MESHES = ("tool0", "upstream")
GRIPPER_MODELS = ("mimic", "linkage")
"""Fingers that follow their drive, or each a five-bar with its spring."""

_PREFIX = re.compile(r"\w*")

Argument = str | bool | int | float | Path | tuple[float, ...] | list[float] | None


@final
@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """A robot, as the model the engines read and as the URDF everyone else does."""

    model: RobotModel
    source: Path
    """The xacro or URDF file it was read from."""
    arm: str | None = None
    """Its names in the catalogue; None for a person's own file."""
    gripper: str | None = None
    prefix: str = ""
    _document: Document = field(repr=False, compare=False)

    @cached_property
    def urdf(self) -> str:
        """The whole robot as one URDF document, without xacro."""
        return to_text(self._document)


def arms() -> tuple[str, ...]:
    """Return the names of the arms."""
    return _models("default_kinematics.yaml")


def grippers() -> tuple[str, ...]:
    """Return the names of the grippers."""
    return _models("kinematics.yaml")


def assemble(
    arm: str = "ur5",
    gripper: str | None = "2f85",
    *,
    prefix: str = "",
    **args: Argument,
) -> RobotDescription:
    """Return ``arm`` with ``gripper`` on its tool0, standing in ``world``.

    Args:
        arm: One of ``arms()``.
        gripper: One of ``grippers()``, or None or "none" for a bare arm.
        prefix: Starts every name but ``world``.
        args: Arguments of ``ur_robotiq.urdf.xacro``; None leaves one at its
            default.  Paths count from the working directory.

    Raises:
        DescriptionError: If a name, an argument or a file is not there or wrong.
        ModelError: If the parameters are those of no robot.
    """
    gripper = gripper or NO_GRIPPER
    _check("arm", arm, arms())
    _check("gripper", gripper, (*grippers(), NO_GRIPPER))
    if not _PREFIX.fullmatch(prefix):
        raise DescriptionError(
            f"the prefix '{prefix}' has characters that no name may have; "
            "use letters, digits and underscores, such as left_"
        )
    _check("meshes", str(args.get("meshes") or MESHES[0]), MESHES)
    gripper_model = str(args.get("gripper_model") or GRIPPER_MODELS[0])
    _check("gripper model", gripper_model, GRIPPER_MODELS)
    if gripper == NO_GRIPPER and gripper_model != GRIPPER_MODELS[0]:
        raise DescriptionError(
            f"gripper_model {gripper_model} is of a gripper, and there is none; "
            f"name a gripper ({', '.join(grippers())}), or leave gripper_model out"
        )
    path = _package() / "urdf" / "ur_robotiq.urdf.xacro"
    given = {
        key: _to_text(key, value) for key, value in args.items() if value is not None
    }
    document = expand(path, {"arm": arm, "gripper": gripper, "prefix": prefix, **given})
    return RobotDescription(
        model=read_model(document),
        source=path,
        arm=arm,
        gripper=None if gripper == NO_GRIPPER else gripper,
        prefix=prefix,
        _document=document,
    )


def load_robot(
    path: Path | str, args: Mapping[str, Argument] | None = None
) -> RobotDescription:
    """Return the robot in a person's own xacro or URDF file.

    Args:
        path: The file; expanded as xacro unless it is called ``*.urdf``.
        args: Values for its ``<xacro:arg>`` elements.

    Raises:
        DescriptionError: If the file, or one it names, cannot be read.
        ModelError: If it describes no possible robot.
    """
    path = Path(path).expanduser()
    if not path.is_file():
        raise DescriptionError(f"there is no file '{path}'; check the path")
    given = {
        key: _to_text("", value)
        for key, value in (args or {}).items()
        if value is not None
    }
    if path.suffix == ".urdf":
        if given:
            raise DescriptionError(
                f"'{path}' is plain URDF and takes no arguments, got "
                f"{', '.join(given)}; name it *.xacro if it is xacro"
            )
        document = parse_file(path)
    else:
        document = expand(path, given)
    return RobotDescription(model=read_model(document), source=path, _document=document)


def named_poses(description: RobotDescription) -> Poses:
    """Return the poses that tool0 knows for a robot: pose → joint → [rad | m].

    A person's own robot has none.
    """
    if description.arm is None:
        return {}
    return read_poses(description.arm, description.gripper, description.prefix)


def part_names(description: RobotDescription) -> Mapping[str, PartName]:
    """Return what people call the links and joints of a robot, where they do.

    A person's own robot has no such names.
    """
    if description.arm is None:
        return {}
    return read_part_names(description.arm, description.gripper, description.prefix)


def default_controllers(
    description: RobotDescription, file: str = "controllers.yaml"
) -> tuple[str, SourceLocation]:
    """Return the YAML of a robot's controllers, and where its first line stands.

    The joints in it carry the robot's prefix.  ``file`` may be
    ``controllers_gripper_action.yaml`` for the gripper as an action of its own.

    Raises:
        DescriptionError: If the robot is a person's own, which brings its own YAML.
    """
    if description.arm is None:
        raise DescriptionError(
            f"tool0 knows no controllers for '{description.source}'; "
            "give a file of controllers"
        )
    bare = {
        transmission.joint.removeprefix(description.prefix)
        for transmission in description.model.transmissions
    }
    return read_controllers(
        description.arm, description.gripper, description.prefix, bare, file
    )


def _package() -> Path:
    return find_package("tool0_description")


def _models(mark: str) -> tuple[str, ...]:
    found = (_package() / "config").glob(f"*/{mark}")
    return tuple(sorted(path.parent.name for path in found))


def _check(kind: str, name: str, valid: tuple[str, ...]) -> None:
    if name not in valid:
        hint = did_you_mean(name, valid)
        is_told = hint.startswith("; valid")
        more = "" if is_told else f" (there are: {', '.join(valid)})"
        raise DescriptionError(f"unknown {kind} '{name}'{hint}{more}")


def _to_text(key: str, value: Argument) -> str:
    """Return ``value`` as xacro wants it: text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple | list):
        return " ".join(map(str, value))
    if isinstance(value, Path) or (key.endswith("_params") and value):
        # xacro would count a relative path from its own file
        return str(Path(str(value)).expanduser().absolute())
    return str(value)
