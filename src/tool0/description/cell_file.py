"""Reader of cells that are written as YAML files or in the short form.

A cell consists of several robots and the objects around them::

    robots:
      - {name: left, arm: ur5, gripper: 2f85, base: {xyz: [0, 0.4, 0]}}
      - name: right
        arm: ur5
        base: {xyz: [0, -400mm, 0], rpy: [0, 0, 90deg]}
        initial_pose: up
    scene: table_and_bin

The other keys of a robot are ``mount`` (orientation of the gripper in the frame
``tool0``), ``initial_pose``, ``controllers_file`` and the fields of
``DescriptionConfig``.  The value of ``scene`` is the name of a built-in scene, a file,
or a mapping with the keys of a scene file.  Paths are relative to the folder of the
cell's file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from tool0.description.config import Cell, CellRobot, DescriptionConfig
from tool0.description.scene import Scene
from tool0.description.scene_file import read_scene, scene_path
from tool0.description.units import ANGLE, LENGTH, Quantity, read_number
from tool0.description.yaml_tree import YamlEntry, read_mapping
from tool0.description.yaml_values import Namespace, number_of
from tool0.errors import ConfigError, SourceLocation
from tool0.user_data import expanded

_TEXTS: Final = ("gripper_model", "meshes", "transmission_hw_interface")
_FILES: Final = (
    "joint_limit_params",
    "kinematics_params",
    "physical_params",
    "visual_params",
    "gripper_params",
    "gripper_joint_limit_params",
    "gripper_visual_params",
)
_NUMBERS: Final[Mapping[str, tuple[Quantity, ...]]] = {
    "pedestal_height": (LENGTH,),
    "safety_pos_margin": (ANGLE,),
    "safety_k_position": (),
}
_POSES: Final = ("base", "mount")
_KEYS: Final = (
    *("name", "arm", "gripper", *_POSES, "initial_pose", "controllers_file"),
    *_TEXTS,
    *_FILES,
    *_NUMBERS,
    "safety_limits",
)
_FORM: Final = "NAME=ARM[+GRIPPER][@X,Y,Z[,ROLL,PITCH,YAW]]"


def load_cell(path: Path | str) -> Cell:
    """Return the cell in a YAML file.

    Raises:
        ConfigError: If the file contains a mistake.  The error states the file and the
            line.
    """
    path = expanded(path)
    root = Namespace(read_mapping(path))
    root.only("robots", "scene", "namespaces")
    listed = root.find("robots")
    return Cell(
        name=re.sub(r"\W", "_", path.stem),
        robots=tuple(_robot(entry, path.parent) for entry in root.items("robots")),
        scene=_scene(root, path.parent),
        namespaces=root.boolean("namespaces", False),
        location=SourceLocation(path, 1) if listed is None else listed.location,
    )


def parse_robots(words: Sequence[str]) -> Cell:
    """Return the cell that is given in short form, such as ``left=ur5+2f85@0,0.4,0``.

    Raises:
        ConfigError: If a robot is not written in the short form.
    """
    return Cell(robots=tuple(map(_parsed, words)))


def _parsed(word: str) -> CellRobot:
    name, _, rest = word.partition("=")
    parts, at, numbers = rest.partition("@")
    arm, plus, gripper = parts.partition("+")
    given = numbers.split(",") if at else []
    if not (name and arm) or (plus and not gripper) or len(given) not in (0, 3, 6):
        raise ConfigError(
            f"'{word}': write {_FORM}, such as left=ur5+2f85@0,0.4,0 (without blanks)"
        )
    try:
        xyz = tuple(read_number(text, LENGTH)[0] for text in given[:3])
        rpy = tuple(read_number(text, ANGLE)[0] for text in given[3:])
    except ConfigError as error:
        raise ConfigError(f"'{word}': {error}") from None
    return CellRobot(
        name=name,
        description=DescriptionConfig(
            arm=arm, gripper=gripper or None, base_xyz=xyz or None, base_rpy=rpy or None
        ),
    )


def _robot(entry: YamlEntry, folder: Path) -> CellRobot:
    values = Namespace(entry)
    values.only(*_KEYS)
    given: dict[str, Any] = {}  # keyword arguments of several types
    for name in _TEXTS:
        if values.find(name):
            given[name] = values.text(name)
    for name in _FILES:
        if values.find(name):
            given[name] = folder / expanded(values.text(name))
    for name, quantities in _NUMBERS.items():
        if values.find(name):
            given[name] = values.number(name, None, *quantities)
    for name in _POSES:
        if pose := values.namespace(name):
            pose.only("xyz", "rpy")
            for key, quantity in (("xyz", LENGTH), ("rpy", ANGLE)):
                if pose.find(key):
                    given[f"{name}_{key}"] = pose.vector(key, None, quantity)
    own = values.find("controllers_file")
    return CellRobot(
        name=values.text("name"),
        description=DescriptionConfig(
            arm=_part(values, "arm", folder) or values.text("arm"),
            gripper=_part(values, "gripper", folder),
            safety_limits=values.boolean("safety_limits", False),
            **given,
        ),
        initial_pose=_initial_pose(values),
        controllers_file=own and folder / expanded(values.text("controllers_file")),
        location=entry.location,
    )


def _part(values: Namespace, kind: str, folder: Path) -> str | None:
    """Return a part's name, or the part's folder if the value contains a slash."""
    found = values.find(kind)
    if found is None or found.is_null:
        return None
    name = values.text(kind)
    return str(folder / expanded(name)) if "/" in name else name


def _initial_pose(values: Namespace) -> str | Mapping[str, float] | None:
    found = values.find("initial_pose")
    if found is None:
        return None
    if not found.is_mapping:
        return values.text("initial_pose")
    return {
        joint: number_of(entry, ANGLE, LENGTH)
        for joint, entry in found.children.items()
    }


def _scene(root: Namespace, folder: Path) -> Scene | Path | None:
    found = root.find("scene")
    if found is None or found.is_null:
        return None
    if found.is_mapping:
        return read_scene(found)
    name = root.text("scene")
    near = folder / expanded(name)
    try:
        return near if near.is_file() else scene_path(name)
    except ConfigError as error:
        raise ConfigError(error.message, found.location) from None
