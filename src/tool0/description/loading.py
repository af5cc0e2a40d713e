"""Loading of robot descriptions, from built-in arms and grippers or your own file."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Final, final

from tool0.description.arm_files import ARM_FILES, check_arm_files
from tool0.description.assumed_drives import assume_drives
from tool0.description.catalogue import (
    NO_GRIPPER,
    CataloguePart,
    DisplayName,
    check_choice,
    find_part,
    grippers,
)
from tool0.description.cell import check_bases, merge_robots
from tool0.description.cell_file import load_cell, parse_robots
from tool0.description.config import SPAWN_Z, Argument, Cell, DescriptionConfig
from tool0.description.expansion import expand
from tool0.description.gripper_files import GRIPPER_FILES, check_gripper_files
from tool0.description.known_grippers import add_known_grippers
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.packages import (
    BUNDLED,
    find_package,
    packages_around,
    preferring,
)
from tool0.description.relaxed_inertia import require_inertias
from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.description.srdf import read_disabled_collisions
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_file
from tool0.errors import DescriptionError
from tool0.user_data import expanded

DEFAULT_ARM = "ur5"
DEFAULT_GRIPPER = "2f85"
MESHES = ("tool0", "upstream")
GRIPPER_MODELS = ("mimic", "linkage")

_LINKAGE_FILE = "linkage.yaml"
"""File name of a gripper's linkage model.  Some grippers do not have this file."""
_PREFIX = re.compile(r"\w*")
_UPRIGHT = 0.01
"""Largest tilt at which an arm has a pedestal [rad]."""
_MAX_BUILT_IN: Final = 16
"""Number of built-in robots that are kept, because their expansion takes most of the
time of a bring-up."""

_ARM_ARGUMENTS = {
    "default_kinematics": "kinematics_params",
    "joint_limits": "joint_limit_params",
    "physical_parameters": "physical_params",
    "visual_parameters": "visual_params",
}
"""Map from a file in the arm's folder to the xacro argument that replaces the file."""

_GRIPPER_ARGUMENTS = {
    "joint_limits": "gripper_joint_limit_params",
    "physical_parameters": "gripper_params",
    "visual_parameters": "gripper_visual_params",
}
"""Map from a file in the gripper's folder to the xacro argument that replaces the
file."""

Poses = Mapping[str, Mapping[str, float]]
"""Joint positions [rad | m] by pose name and joint name."""


def load_description(
    config: DescriptionConfig, *, spawn_z: float = SPAWN_Z
) -> RobotDescription:
    """Return the selected robot; an arm from the catalogue is fixed to ``world``.

    The arm's pedestal reaches the ground, which is ``spawn_z`` [m] below ``world``.

    Raises:
        DescriptionError: If a name, an argument or a file is missing or wrong.
        ModelError: If the parameters are physically impossible.
        ConfigError: If a cell is invalid.
    """
    description = _loaded(config, spawn_z)
    if config.srdf is None:
        return description
    pairs = read_disabled_collisions(expanded(config.srdf), description.model)
    return replace(description, disabled_collisions=pairs)


def _loaded(config: DescriptionConfig, spawn_z: float) -> RobotDescription:
    if config.robot is not None:
        return load_robot(
            config.robot,
            config.args,
            is_driven=config.ros2_control,
            relax_inertia=config.relax_inertia,
        )
    cell = _cell_of(config)
    if cell is not None:
        return _load_cell(cell, spawn_z)
    robot, urdf = _expand_robot(config, spawn_z)
    return RobotDescription(
        model=urdf.model,
        source=_catalogue_file(),
        robots=(robot,),
        tf_prefix=urdf.arguments["tf_prefix"],
        arguments=dict(urdf.arguments),
        _document=urdf.document,
    )


def _cell_of(config: DescriptionConfig) -> Cell | None:
    if config.robots is not None:
        cell = parse_robots(config.robots)
    elif isinstance(config.cell, Cell):
        cell = config.cell
    elif config.cell is not None:
        cell = load_cell(config.cell)
    else:
        return None
    if config.ros2_control:
        robots = (
            replace(item, description=replace(item.description, ros2_control=True))
            for item in cell.robots
        )
        cell = replace(cell, robots=tuple(robots))
    return replace(cell, namespaces=True) if config.namespaces else cell


def _load_cell(cell: Cell, spawn_z: float) -> RobotDescription:
    """Return the robots of a cell as one robot description."""
    robots, documents = [], []
    for item in cell.robots:
        try:
            robot, urdf = _expand_robot(item.description, spawn_z, item.name)
        except DescriptionError as error:
            location = error.location or item.location
            message = f"robot '{item.name}': {error.message}"
            raise DescriptionError(message, location) from None
        robots.append(robot)
        documents.append(urdf.document)
    name = "_".join([*(robot.prefix + robot.arm.name for robot in robots), "robot"])
    document = merge_robots(cell, cell.name or name, documents)
    model = read_model(document)
    check_bases(cell, model)
    file = cell.location.file if cell.location else None
    return RobotDescription(
        model=model,
        source=file or _catalogue_file(),
        robots=tuple(robots),
        cell=cell,
        _document=document,
    )


@final
class _CatalogueUrdf:
    """The expanded URDF of a robot from the catalogue, which must not be changed."""

    def __init__(self, file: Path, arguments: Mapping[str, str]) -> None:
        self.document, _, self.arguments = expand(file, arguments)

    @cached_property
    def model(self) -> RobotModel:
        return read_model(self.document)


def _expand_robot(
    config: DescriptionConfig, spawn_z: float, name: str = ""
) -> tuple[CatalogueRobot, _CatalogueUrdf]:
    """Return an arm from the catalogue with its gripper, and the expanded URDF.

    A ``name`` that is not empty means that the arm is a robot of a cell.
    """
    prefix = f"{name}_" if name else ""
    defaults = {"arm": DEFAULT_ARM, "gripper": DEFAULT_GRIPPER, "prefix": prefix}
    given = {**defaults, **_to_texts(config.xacro_arguments())}
    given.setdefault("pedestal_height", _pedestal_height(given, spawn_z))
    gripper, prefix = given["gripper"], given["prefix"]
    gripper_model = given.get("gripper_model", GRIPPER_MODELS[0])
    robot = CatalogueRobot(
        name=name,
        arm=find_part("arm", given["arm"]),
        gripper=None if gripper == NO_GRIPPER else find_part("gripper", gripper),
        prefix=prefix,
    )
    check_choice("meshes", given.get("meshes", MESHES[0]), MESHES)
    check_choice("gripper model", gripper_model, GRIPPER_MODELS)
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
    if robot.gripper is not None and gripper_model == "linkage":
        _check_linkage(robot.gripper)
    check_arm_files(_own_files(robot.arm, ARM_FILES, _ARM_ARGUMENTS, given))
    if robot.gripper is not None:
        own = _own_files(robot.gripper, GRIPPER_FILES, _GRIPPER_ARGUMENTS, given)
        check_gripper_files(own)
    given["arm"] = str(robot.arm.folder)
    if robot.gripper is not None:
        given["gripper"] = str(robot.gripper.folder)
    file = _catalogue_file()
    if _is_built_in(file, robot, given):
        return robot, _built_in_urdf(file, tuple(given.items()))
    return robot, _CatalogueUrdf(file, given)


@lru_cache(maxsize=_MAX_BUILT_IN)
def _built_in_urdf(
    file: Path, arguments: tuple[tuple[str, str], ...]
) -> _CatalogueUrdf:
    return _CatalogueUrdf(file, dict(arguments))


def _is_built_in(file: Path, robot: CatalogueRobot, given: Mapping[str, str]) -> bool:
    """Return whether only files of tool0 define a robot with the given arguments."""
    return (
        file.is_relative_to(BUNDLED)
        and all(part.is_built_in for part in robot.parts)
        and not any(given[name] for name in given if name.endswith("_params"))
        and given.get("meshes", MESHES[0]) == MESHES[0]
    )


def _catalogue_file() -> Path:
    return find_package("tool0_description") / "urdf" / "ur_robotiq.urdf.xacro"


def assemble(
    arm: str = DEFAULT_ARM, gripper: str | None = DEFAULT_GRIPPER, **args: Argument
) -> RobotDescription:
    """Return ``arm`` with ``gripper`` and the given xacro arguments.

    The function raises the same errors as ``load_description``.
    """
    return load_description(DescriptionConfig(arm=arm, gripper=gripper, args=args))


def load_robot(
    path: Path | str,
    args: Mapping[str, Argument] | None = None,
    *,
    is_driven: bool = False,
    relax_inertia: bool = False,
) -> RobotDescription:
    """Return the robot in your own file, a xacro file unless it ends in ``.urdf``.

    Packages of the workspace that contains the file take precedence over all other
    packages.  If ``is_driven`` is set and the file does not declare which joints are
    driven, every joint is driven.  If ``relax_inertia`` is set, physically impossible
    inertias are replaced.

    Raises:
        DescriptionError: If the file, or a file to which it refers, cannot be read.
        ModelError: If the file's parameters are physically impossible.
    """
    path = expanded(path)
    if not path.is_file():
        raise DescriptionError(f"there is no file '{path}'; check the path")
    given: Mapping[str, str] = _to_texts(args or {}, ours=False)
    if path.suffix == ".urdf" and given:
        raise DescriptionError(
            f"'{path}' is plain URDF, which takes no arguments, got "
            f"{', '.join(given)}; name it *.xacro if it is xacro"
        )
    with preferring(packages_around(path)):
        if path.suffix == ".urdf":
            document = parse_file(path)
        else:
            document, _, given = expand(path, given)
        if is_driven:
            assume_drives(document)
        require_inertias(document, relax=relax_inertia)
        add_known_grippers(document, _built_in_gripper)
        return RobotDescription(
            model=read_model(document), source=path, arguments=given, _document=document
        )


def _built_in_gripper(name: str) -> ParallelGripper:
    """Return a built-in gripper with the relation between its opening and its joint."""
    return assemble(gripper=name).model.grippers[0]


def named_poses(description: RobotDescription) -> Poses:
    """Return the built-in poses of a robot; none for a robot in your own file.

    If several parts define a pose of the same name, such as ``home``, the pose contains
    the joints of all these parts.
    """
    poses: dict[str, dict[str, float]] = {}
    for robot in description.robots:
        for part in robot.parts:
            for name, positions in part.load("poses").items():
                pose = poses.setdefault(name, {})
                pose.update({robot.prefix + j: q for j, q in positions.items()})
    return poses


def part_names(description: RobotDescription) -> Mapping[str, DisplayName]:
    """Return the display names of links and joints; none for your own file."""
    return {
        robot.prefix + item: DisplayName(en=names["en"], zh=names["zh"])
        for robot in description.robots
        for part in robot.parts
        for item, names in part.load("part_names").items()
    }


def _check_linkage(gripper: CataloguePart) -> None:
    """Raise DescriptionError unless the gripper has a linkage model."""
    if not gripper.file(_LINKAGE_FILE).is_file():
        having = [
            name
            for name in grippers()
            if find_part("gripper", name).file(_LINKAGE_FILE).is_file()
        ]
        raise DescriptionError(
            f"gripper_model linkage: the fingers of '{gripper.name}' are no linkages; "
            f"grippers with this model: {', '.join(having)}"
        )


def _own_files(
    part: CataloguePart,
    names: Sequence[str],
    arguments: Mapping[str, str],
    given: Mapping[str, str],
) -> Mapping[str, Path]:
    """Return the user's YAML files for a part, by file name."""
    files = {}
    if not part.is_built_in:
        files = {name: part.folder / f"{name}.yaml" for name in names}
    instead = {
        name: Path(given[argument])
        for name, argument in arguments.items()
        if given.get(argument)
    }
    return {**files, **instead}


def _pedestal_height(given: Mapping[str, str], spawn_z: float) -> str:
    """Return the height of the base above the ground [m]; 0 if the arm is tilted."""
    try:
        z = float(given.get("base_xyz", "0 0 0").split()[2])
        roll, pitch, _ = map(float, given.get("base_rpy", "0 0 0").split())
    except (IndexError, ValueError):  # the xacro file reports the wrong value
        return "0"
    height = round(spawn_z + z, 9)
    stands = 0.0 < height < math.inf and math.hypot(roll, pitch) < _UPRIGHT
    return repr(height if stands else 0.0)


def _to_texts(args: Mapping[str, Argument], *, ours: bool = True) -> dict[str, str]:
    """Return the given arguments as text for xacro.

    If ``ours`` is set, the arguments are those of tool0's own xacro file.  Each
    argument ``…_params`` is then a path and is made absolute, since xacro would resolve
    a relative path from the folder of the xacro file.
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
