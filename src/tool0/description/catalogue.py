"""The built-in robots, and the description of any robot.

The built-in arms and grippers are the folders in ``tool0_description/config``: an arm
has ``default_kinematics.yaml``, a gripper has ``kinematics.yaml``.  They also contain
poses, controllers and display names of the parts.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from tool0.description.config import SPAWN_Z, Argument, DescriptionConfig
from tool0.description.expansion import expand
from tool0.description.model import RobotModel
from tool0.description.packages import find_package
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_file, to_text
from tool0.description.yaml_tree import read_verbatim
from tool0.errors import DescriptionError, SourceLocation, did_you_mean
from tool0.user_data import expanded

if TYPE_CHECKING:
    from xml.dom.minidom import Document

NO_GRIPPER = "none"
MESHES = ("tool0", "upstream")
GRIPPER_MODELS = ("mimic", "linkage")

_PREFIX = re.compile(r"\w*")
_UPRIGHT = 0.01
"""Largest tilt of an arm that stands on a pedestal [rad]."""

Poses = Mapping[str, Mapping[str, float]]
"""Pose → joint → position [rad | m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayName:
    """The display name of a link or joint."""

    en: str
    zh: str


@final
@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """A robot: the model for the engines, and the URDF for everything else."""

    model: RobotModel
    """Links, joints, drives and grippers, checked."""
    source: Path
    """The xacro or URDF file that it was read from."""
    arm: str | None = None
    """Name of the arm in the catalogue; None for your own file."""
    gripper: str | None = None
    """Name of the gripper in the catalogue; None without one."""
    prefix: str = ""
    """Prefix of the names of its links and joints."""
    tf_prefix: str = ""
    """Prefix of its frames in ROS."""
    _document: Document = field(repr=False, compare=False)

    @cached_property
    def urdf(self) -> str:
        """The whole robot as one URDF document, without xacro."""
        return to_text(self._document)

    @property
    def folders(self) -> tuple[str, ...]:
        """The folders of its arm and gripper in ``tool0_description/config``."""
        return tuple(name for name in (self.arm, self.gripper) if name is not None)


def arms() -> tuple[str, ...]:
    """Return the names of the built-in arms."""
    return _models("default_kinematics.yaml")


def grippers() -> tuple[str, ...]:
    """Return the names of the built-in grippers."""
    return _models("kinematics.yaml")


def load_description(
    config: DescriptionConfig, *, spawn_z: float = SPAWN_Z
) -> RobotDescription:
    """Return the robot that ``config`` describes; a catalogue arm stands in ``world``.

    Its pedestal reaches to the ground, ``spawn_z`` [m] below ``world``.

    Raises:
        DescriptionError: If a name, an argument or a file is missing or wrong.
        ModelError: If the parameters are physically impossible.
    """
    if config.robot is not None:
        return load_robot(config.robot, config.args)
    defaults = {"arm": "ur5", "gripper": "2f85", "prefix": ""}
    given = {**defaults, **_to_texts(config.xacro_arguments())}
    given.setdefault("pedestal_height", _pedestal_height(given, spawn_z))
    arm, gripper, prefix = given["arm"], given["gripper"], given["prefix"]
    gripper_model = given.get("gripper_model", GRIPPER_MODELS[0])
    _check("arm", arm, arms())
    _check("gripper", gripper, (*grippers(), NO_GRIPPER))
    _check("meshes", given.get("meshes", MESHES[0]), MESHES)
    _check("gripper model", gripper_model, GRIPPER_MODELS)
    if not _PREFIX.fullmatch(prefix):
        raise DescriptionError(
            f"the prefix '{prefix}' has characters that names must not have; "
            "use letters, digits and underscores, such as left_"
        )
    if gripper == NO_GRIPPER and gripper_model != GRIPPER_MODELS[0]:
        raise DescriptionError(
            f"gripper_model {gripper_model} needs a gripper "
            f"({', '.join(grippers())}), but the robot has none"
        )
    path = _package() / "urdf" / "ur_robotiq.urdf.xacro"
    document = expand(path, given)
    return RobotDescription(
        model=read_model(document),
        source=path,
        arm=arm,
        gripper=None if gripper == NO_GRIPPER else gripper,
        prefix=prefix,
        tf_prefix=given.get("tf_prefix", ""),
        _document=document,
    )


def assemble(
    arm: str = "ur5", gripper: str | None = "2f85", **args: Argument
) -> RobotDescription:
    """Return ``arm`` with ``gripper`` and further xacro arguments.

    See ``load_description`` for the errors.
    """
    return load_description(DescriptionConfig(arm=arm, gripper=gripper, args=args))


def load_robot(
    path: Path | str, args: Mapping[str, Argument] | None = None
) -> RobotDescription:
    """Return the robot in your own file, which is xacro unless it ends in ``.urdf``.

    Raises:
        DescriptionError: If the file, or a file it refers to, cannot be read.
        ModelError: If its parameters are physically impossible.
    """
    path = expanded(path)
    if not path.is_file():
        raise DescriptionError(f"there is no file '{path}'; check the path")
    given = _to_texts(args or {}, ours=False)
    if path.suffix == ".urdf":
        if given:
            raise DescriptionError(
                f"'{path}' is plain URDF, which takes no arguments, got "
                f"{', '.join(given)}; name it *.xacro if it is xacro"
            )
        document = parse_file(path)
    else:
        document = expand(path, given)
    return RobotDescription(model=read_model(document), source=path, _document=document)


def config_file(folder: str, file: str) -> Path:
    """Return a file of the arm, the gripper or the pair in ``folder``."""
    return _package() / "config" / folder / file


def named_poses(description: RobotDescription) -> Poses:
    """Return the built-in poses of a robot; your own file has none.

    If the arm and the gripper both have a pose such as ``home``, it sets both.
    """
    poses: dict[str, dict[str, float]] = {}
    for folder in description.folders:
        for name, positions in _load(folder, "poses").items():
            pose = poses.setdefault(name, {})
            pose.update({description.prefix + j: q for j, q in positions.items()})
    return poses


def part_names(description: RobotDescription) -> Mapping[str, DisplayName]:
    """Return the display names of links and joints; your own file has none."""
    return {
        description.prefix + part: DisplayName(en=names["en"], zh=names["zh"])
        for folder in description.folders
        for part, names in _load(folder, "part_names").items()
    }


def default_controllers(
    description: RobotDescription, file: str = "controllers.yaml"
) -> tuple[str, SourceLocation]:
    """Return the YAML of a robot's controllers, and the location of its first line.

    Its joints have the robot's prefix; line breaks are unchanged, so line numbers in
    messages are those of the file.  ``file`` may be
    ``controllers_gripper_action.yaml``, which drives the gripper by an action.

    Raises:
        DescriptionError: If there are none, as for your own robot file.
    """
    if description.arm is None:
        raise DescriptionError(
            f"there are no built-in controllers for '{description.source}'; "
            "give a file of controllers"
        )
    path = config_file("_".join(description.folders), file)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise DescriptionError(
            f"there are no controllers for this robot: cannot read '{path}'; "
            "give a file of controllers"
        ) from error
    if description.prefix:
        joints = {
            transmission.joint.removeprefix(description.prefix)
            for transmission in description.model.transmissions
        }
        text = _with_prefix(text, description.prefix, joints)
    return text, SourceLocation(path, 1)


def _pedestal_height(given: Mapping[str, str], spawn_z: float) -> str:
    """Return the height from the ground to the arm's base [m]; 0 if it is tilted."""
    try:
        z = float(given.get("base_xyz", "0 0 0").split()[2])
        roll, pitch, _ = map(float, given.get("base_rpy", "0 0 0").split())
    except (IndexError, ValueError):  # the xacro complains
        return "0"
    height = round(spawn_z + z, 9)
    stands = 0.0 < height < math.inf and math.hypot(roll, pitch) < _UPRIGHT
    return repr(height if stands else 0.0)


def all_default_controllers() -> Iterator[tuple[str, SourceLocation]]:
    """Yield the YAML of all built-in controllers, those of most parts first."""
    paths = (_package() / "config").glob("*/controllers.yaml")
    folders = sorted(
        (path.parent.name for path in paths), key=lambda name: (-name.count("_"), name)
    )
    for path in (config_file(folder, "controllers.yaml") for folder in folders):
        yield path.read_text(encoding="utf-8"), SourceLocation(path, 1)


def _package() -> Path:
    return find_package("tool0_description")


def _models(mark: str) -> tuple[str, ...]:
    found = (_package() / "config").glob(f"*/{mark}")
    return tuple(sorted(path.parent.name for path in found))


def _check(kind: str, name: str, valid: tuple[str, ...]) -> None:
    if name not in valid:
        hint = did_you_mean(name, valid)
        lists_all = hint.startswith("; valid")
        more = "" if lists_all else f" (there are: {', '.join(valid)})"
        raise DescriptionError(f"unknown {kind} '{name}'{hint}{more}")


def _to_texts(args: Mapping[str, Argument], *, ours: bool = True) -> dict[str, str]:
    """Return the given arguments as text for xacro.

    In ``ours``, each ``…_params`` is a path, made absolute here: xacro would resolve a
    relative one from the folder of its own file.
    """
    texts = {}
    for name, value in args.items():
        if isinstance(value, bool):
            texts[name] = "true" if value else "false"
        elif isinstance(value, Path) or (ours and name.endswith("_params") and value):
            texts[name] = str(expanded(str(value)).absolute())
        elif isinstance(value, Sequence) and not isinstance(value, str):
            texts[name] = " ".join(map(str, value))
        elif value is not None:
            texts[name] = str(value)
    return texts


def _load(folder: str, what: str) -> Mapping[str, Any]:  # Any: any YAML value
    """Return the content of ``config/<folder>/<what>.yaml``; empty without the file."""
    path = config_file(folder, f"{what}.yaml")
    entries = read_verbatim(path).root.children[what].children if path.is_file() else {}
    return {name: entry.plain() for name, entry in entries.items()}


def _with_prefix(text: str, prefix: str, joints: Collection[str]) -> str:
    """Return YAML ``text`` with ``prefix`` before each scalar that is a joint."""
    import yaml

    starts = [
        token.start_mark.index
        for token in yaml.scan(text, yaml.SafeLoader)
        if isinstance(token, yaml.ScalarToken) and token.value in joints
    ]
    for start in reversed(starts):
        after_quote = start + (text[start] in "\"'")
        text = text[:after_quote] + prefix + text[after_quote:]
    return text
