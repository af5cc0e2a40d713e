"""The built-in controllers of a robot with drives from ``<ros2_control>`` tags.

As for ROS 1, ``tool0_description/config`` contains a file that all arms share and a
file that all grippers share.  The folder of an arm or a gripper may contain a separate
file for this arm or gripper.  Each controller specifies its type; the section of the
manager is assembled from these types.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NamedTuple, final

from tool0.control.controller_parts import (
    LIMITS,
    OwnArm,
    Row,
    common_interface,
    joints_beyond,
    limits_row,
    lines_of,
    own_arms,
    part_file,
    rating,
    read_part,
    renamed,
)
from tool0.control.parameters import joint_entries
from tool0.control.ros2.layout import declared
from tool0.description.model import Interface, JointType, RobotModel
from tool0.description.packages import find_package
from tool0.description.parts import joints_of
from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.description.yaml_tree import Tree, read_verbatim
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation

_FILE: Final = "controllers_ros2.yaml"
_STARTED_FILE: Final = "started_controllers_ros2.yaml"
_ACTIVATION: Final = "robotiq_activation_controller:"
"""The last controller in the file of a gripper.  Several activation controllers would
claim the same interface."""
_RATE: Final = 500
"""Update rate for arms with no update rate in their folder [Hz]."""
_ROTARY: Final = {"$tolerance": "0.02"}
"""Settings of a gripper with a revolute driven joint [rad]."""
_LINEAR: Final = {"$tolerance": "0.0005"}
"""Settings of a gripper with a prismatic driven joint [m].  The tolerance corresponds
to 1 mm of opening."""


class StartedControllers(NamedTuple):
    """The controllers that a bring-up starts if the YAML defines them."""

    always: tuple[str, ...]
    built_in: tuple[str, ...]
    """Additional controllers that are started if the built-in controllers are used."""
    loaded: tuple[str, ...]
    """Built-in controllers that are loaded but not started.  The launch file of UR's
    driver also loads controllers without starting them.  The action servers of loaded
    controllers respond to clients, and ``ros2 control`` can switch to loaded
    controllers."""


def started() -> StartedControllers:
    """Return the controllers that a bring-up starts unless options specify others."""
    file = Namespace(read_verbatim(_config(_STARTED_FILE)).root)
    keys = ("started", "started_built_in", "loaded_built_in")
    return StartedControllers(*map(file.texts, keys))


def _config(name: str) -> Path:
    return find_package("tool0_description") / "config" / name


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class _Piece:
    """The text of a part for one robot."""

    text: str
    location: SourceLocation
    limits: Sequence[Row] = ()

    def tree(self) -> Tree:
        tree = Tree()
        tree.load(self.text, self.location)
        return tree


def built_in_yaml(description: RobotDescription, period: float) -> str:
    """Return the built-in controllers as YAML, or an empty string if none fit.

    ``period`` is the physics step [s]; the update period is a multiple of this step.
    """
    pieces = _pieces(description, period)
    if not pieces:
        return ""
    about = f"# Controllers of {description.title}, for ros2_control and for tool0.\n"
    manager = _manager(description, pieces)
    return "\n".join([about + manager, *(piece.text for piece in pieces)])


def built_in_tree(description: RobotDescription, period: float) -> Tree:
    """Return the built-in controllers, with their locations in the files."""
    tree = Tree()
    pieces = _pieces(description, period)
    if pieces:
        tree.load(_manager(description, pieces), SourceLocation(description.source))
    for piece in pieces:
        tree.load(piece.text, piece.location)
    return tree


def _manager(description: RobotDescription, pieces: Sequence[_Piece]) -> str:
    """Return the parameters of the manager: update rate, types and joint limits."""
    rates = [rating(robot.arm, "update_rate") for robot in description.robots]
    rate = max((round(rate) for rate in rates if rate), default=_RATE)
    types = {
        name: str(item.type.scalar)
        for piece in pieces
        for name, item in declared(piece.tree().root).items()
    }
    text = f"controller_manager:\n  ros__parameters:\n    update_rate: {rate}  # [Hz]\n"
    text += "".join(f"    {name}: {{type: {kind}}}\n" for name, kind in types.items())
    limits = [row for piece in pieces for row in piece.limits]
    if limits:
        text += (
            "    # What the motions of tool0 keep to; ros2_control does not read it.\n"
            f"    {LIMITS}:\n" + lines_of(limits, indent="      ")
        )
    return text


def _pieces(description: RobotDescription, period: float) -> list[_Piece]:
    """Return the parts of all robots; empty if no parts fit the user's robot file."""
    parts = [
        piece
        for robot in description.robots
        for piece in _Composer(description, robot, period).pieces()
    ]
    if not description.robots:
        composer = _Composer(description, None, period)
        for arm in own_arms(description.model):
            parts += composer.own_pieces(arm)
        if not parts:
            parts += composer.own_gripper([g.joint for g in description.model.grippers])
    if not parts:
        return []
    path = _config(_FILE)
    texts = [read_part(path)]
    if description.cell is not None and description.cell.namespaces:
        texts = [
            _joint_states(description, robot, texts[0]) for robot in description.robots
        ]
    location = SourceLocation(path, 1)
    return [*(_Piece(text=text, location=location) for text in texts), *parts]


def _joint_states(
    description: RobotDescription, robot: CatalogueRobot, text: str
) -> str:
    """Return the YAML of a joint state broadcaster for the joints of one robot."""
    states = {
        joint.name
        for component in description.model.hardware
        for joint in component.joints
        if {"position", "velocity"} <= {state.name for state in joint.states}
    }
    joints = [j for j in joints_of(description.model, robot.name) if j in states]
    return (
        f"{renamed(description, robot, text)}    joints: [{', '.join(joints)}]\n"
        "    interfaces: [position, velocity]\n"
    )


@final
@dataclass(frozen=True, slots=True)
class _Composer:
    """Creates the parts of one robot."""

    description: RobotDescription
    robot: CatalogueRobot | None
    """The catalogue robot; None for a robot file of the user, in which names have no
    prefix."""
    period: float

    def pieces(self) -> Iterator[_Piece]:
        """Yield the parts of a catalogue arm and its gripper."""
        model, robot = self.description.model, self.robot
        assert robot is not None
        self._refuse_own_file()
        path = part_file("arm", robot.arm, _FILE)
        text = self._written(read_part(path))
        arm = _joints_in(text, path)
        yield _Piece(
            text=text, location=SourceLocation(path, 1), limits=self._limits(arm)
        )
        hand = joints_beyond(model, arm[-1])
        if robot.gripper and hand:
            yield self._gripper(hand[0])

    def own_pieces(self, arm: OwnArm) -> Iterator[_Piece]:
        """Yield the parts of an arm and its gripper in a robot file of the user.

        The result is empty unless the arm's joints have position interfaces.
        """
        model, wanted = self.description.model, (Interface.POSITION,)
        if common_interface(model, arm.joints, wanted) is None:
            return
        path = part_file("arm", None, _FILE)
        yield _Piece(
            text=arm.written(read_part(path)),
            location=SourceLocation(path, 1),
            limits=self._limits(arm.joints),
        )
        for piece in self.own_gripper(joints_beyond(model, arm.joints[-1])):
            text = piece.text.partition(_ACTIVATION)[0] if arm.prefix else piece.text
            yield replace(piece, text=arm.written(text))

    def own_gripper(self, joints: Sequence[str]) -> Iterator[_Piece]:
        """Yield the part of a gripper that one joint drives, in a user's robot file."""
        wanted = (Interface.POSITION,)
        if len(joints) == 1 and common_interface(
            self.description.model, joints, wanted
        ):
            yield self._gripper(joints[0])

    def _refuse_own_file(self) -> None:
        cell, robot = self.description.cell, self.robot
        for item in cell.robots if cell and robot else ():
            if robot and item.name == robot.name and item.controllers_file:
                raise ConfigError(
                    f"robot '{robot.name}' of the cell has controllers of its own, in "
                    f"'{item.controllers_file}'; with ROS 2, give one YAML for the "
                    "whole cell (--controllers-file)"
                )

    def _written(self, text: str) -> str:
        """Return the text of a part, with the names of this robot."""
        prefix = self.robot.prefix if self.robot else ""
        text = renamed(self.description, self.robot, text)
        return text.replace("$prefix", prefix)

    def _limits(self, joints: Sequence[str]) -> list[Row]:
        from tool0.control.gains import derive_arm_gains

        payload = rating(self.robot.arm, "payload") if self.robot else None
        model = self.description.model
        derived = derive_arm_gains(model, joints, payload, period=self.period)
        return [
            limits_row(self.description, joint, found)
            for joint, found in zip(joints, derived, strict=True)
        ]

    def _gripper(self, joint: str) -> _Piece:
        """Return the part of a gripper that ``joint`` drives."""
        part = self.robot.gripper if self.robot else None
        path = part_file("gripper", part, _FILE)
        slides = self.description.model.joint(joint).type is JointType.PRISMATIC
        text = self._written(read_part(path))
        for name, value in {
            **(_LINEAR if slides else _ROTARY),
            "$joint": joint,
        }.items():
            text = text.replace(name, value)
        text = _without_unknown(text, joint, self.description.model)
        return _Piece(text=text, location=SourceLocation(path, 1))


def _without_unknown(text: str, joint: str, model: RobotModel) -> str:
    """Return YAML, in which blank lines replace interfaces that ``joint`` lacks."""
    known = {name for item in model.hardware for name in item.command_interfaces}
    lines = text.splitlines(keepends=True)
    for number, line in enumerate(lines):
        found = re.search(rf"\s({re.escape(joint)}/\w+)", line)
        if found is not None and found[1] not in known:
            lines[number] = "\n"
    return "".join(lines)


def _joints_in(text: str, path: Path) -> list[str]:
    """Return the joints of the first controller that lists joints."""
    tree = Tree()
    tree.load(text, SourceLocation(path, 1))
    for controller in declared(tree.root).values():
        joints = [str(item.scalar) for item in joint_entries(controller.parameters)]
        if joints:
            return joints
    raise ConfigError("no controller of the arm names joints", SourceLocation(path))
