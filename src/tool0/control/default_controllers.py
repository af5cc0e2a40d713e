"""The built-in controllers of a robot: one part per arm, and one per gripper.

The parts are ros_control YAML files in ``tool0_description/config``: one file that all
arms share, and one file that all grippers share.  The folder of an arm or a gripper may
contain a separate file for this arm or gripper.  In the YAML files, ``$gains`` stands
for the gains in the folder's ``gains.yaml``.  If the folder contains no ``gains.yaml``,
the gains are derived from the model.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.control.config import ControllerConfig
from tool0.control.controller_parts import (
    CATALOGUE_JOINTS,
    LIMITS,
    OwnArm,
    Row,
    common_interface,
    controller_prefix,
    joints_beyond,
    limits_row,
    lines_of,
    number_text,
    own_arms,
    part_file,
    rating,
    read_part,
    renamed,
)
from tool0.control.ros2 import built_in
from tool0.control.ros2.dialect import ROS2
from tool0.description.catalogue import CataloguePart
from tool0.description.model import Interface, JointType
from tool0.description.packages import find_package
from tool0.description.parts import joints_of
from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.description.yaml_tree import Tree, YamlEntry, read_verbatim
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, DescriptionError, SourceLocation
from tool0.user_data import expanded

if TYPE_CHECKING:
    from tool0.control.gains import DerivedGains

PERIOD: Final = 0.001
"""Time between controller updates for which the gains are derived [s]."""
_FILE: Final = "controllers.yaml"
_ACTION_FILE: Final = "controllers_gripper_action.yaml"
_BY_PREFERENCE: Final = (Interface.EFFORT, Interface.POSITION)
_FILES: Final = {
    Interface.EFFORT: _FILE,
    Interface.POSITION: "controllers_position.yaml",
}
"""The files that define controllers, by the interface of the joints."""
_GAINS: Final = "$gains"
_STATE_CONTROLLER: Final = "joint_state_controller"
"""Name of the controller that publishes joint states.  There is one joint state
controller for all robots or, if the robots have namespaces, one for each robot."""
_ROTARY: Final = {"$tolerance": "0.002", "$standstill": "0.001"}
"""Settings of a gripper with a revolute driven joint [rad, rad/s]."""
_LINEAR: Final = {"$tolerance": "0.0001", "$standstill": "0.0001"}
"""Settings of a gripper with a prismatic driven joint [m, m/s].  The tolerance
corresponds to 0.2 mm of opening."""


def controllers_yaml(
    description: RobotDescription,
    *,
    gripper_action: bool = False,
    period: float = PERIOD,
) -> str:
    """Return the built-in controllers as YAML; comments describe the gains' origin.

    Args:
        description: The robot or robots.
        gripper_action: Whether grippers use a GripperActionController instead of a
            JointTrajectoryController.
        period: Time between updates of the controllers [s].

    Raises:
        DescriptionError: If no built-in controllers fit, which can happen for a robot
            file of the user.
        ConfigError: If the file of a part is invalid, or ``gripper_action`` is given
            for a gripper without an effort interface.
    """
    nothing_fits = DescriptionError(
        f"there are no built-in controllers for '{description.source}'; "
        "give a file of controllers"
    )
    if has_ros2_controllers(description, gripper_action=gripper_action):
        text = built_in.built_in_yaml(description, period)
        if not text:
            raise nothing_fits
        return text
    pieces = _pieces(description, gripper_action, period)
    if not pieces:
        raise nothing_fits
    about = f"# Controllers of {description.title}, for ros_control and for tool0.\n"
    limits = [row for piece in pieces for row in piece.limits]
    texts = [about, *(piece.yaml() for piece in pieces)]
    if limits:
        texts.append(
            "# What the motions of tool0 keep to; ros_control does not enforce it.\n"
            f"{LIMITS}:\n" + lines_of(limits, indent="  ")
        )
    return "\n".join(texts)


def default_controllers(
    description: RobotDescription,
    *,
    gripper_action: bool = False,
    period: float = PERIOD,
) -> ControllerConfig:
    """Return the built-in controllers, with their locations in the files.

    The result is empty if no built-in controllers fit the user's robot file.

    Raises:
        ConfigError: If the file of a part is invalid, or ``gripper_action`` is given
            for a gripper without an effort interface.
    """
    if has_ros2_controllers(description, gripper_action=gripper_action):
        return ControllerConfig(built_in.built_in_tree(description, period), ROS2)
    tree = Tree()
    for piece in _pieces(description, gripper_action, period):
        piece.load_into(tree)
    return ControllerConfig(tree)


def has_ros2_controllers(
    description: RobotDescription, *, gripper_action: bool = False
) -> bool:
    """Return whether the robot has ROS 2 controllers.

    A robot with ``<ros2_control>`` tags has ROS 2 controllers.

    Raises:
        ConfigError: If the robot has ROS 2 controllers, but ``gripper_action`` requests
            a ROS 1 controller.
    """
    has = bool(description.model.hardware)
    if has and gripper_action:
        raise ConfigError(
            "gripper_action is for ROS 1: with ROS 2, a gripper always has an action; "
            "leave it out"
        )
    return has


def controller_prefixes(description: RobotDescription) -> tuple[str, ...]:
    """Return the controllers' prefix of each robot, such as ``left_`` for ``left``."""
    if description.robots:
        return tuple(map(controller_prefix, description.robots))
    return tuple(arm.prefix for arm in own_arms(description.model)) or ("",)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class _Piece:
    """The text of a part for one robot, and the rows to insert into it."""

    text: str
    location: SourceLocation
    gains: Sequence[Row] = ()
    limits: Sequence[Row] = ()

    def yaml(self) -> str:
        """Return the text with the inserted gains."""
        lines = self.text.splitlines(keepends=True)
        return "".join(
            lines_of(self.gains, line[: line.index(_GAINS)])
            if line.strip() == _GAINS
            else line
            for line in lines
        )

    def load_into(self, tree: Tree) -> None:
        """Add the parameters to ``tree``."""
        tree.load(self.text, self.location)
        for name, controller in tree.root.children.items():
            gains = controller.find("gains")
            if gains is not None and gains.scalar == _GAINS:
                gains.value = {}
                _load_rows(tree, f"{name}: {{gains: {{", self.gains, "}}")
        _load_rows(tree, f"{LIMITS}: {{", self.limits, "}")


def _load_rows(tree: Tree, start: str, rows: Sequence[Row], end: str) -> None:
    """Add the rows as one text per file, and keep their line numbers."""
    for file in dict.fromkeys(row.location.file for row in rows):
        text, line = start, 1
        for row in rows:
            if row.location.file == file:
                gap = max((row.location.line or 1) - line, 0)
                text += "\n" * gap + f" {row.joint}: {row.values},"
                line += gap
        tree.load(text + end, SourceLocation(file, 1))


def _pieces(
    description: RobotDescription, gripper_action: bool, period: float
) -> list[_Piece]:
    """Return the parts of all robots; empty if no parts fit the user's robot file."""
    parts = [
        piece
        for robot in description.robots
        for piece in _Composer(description, robot, gripper_action, period).pieces()
    ]
    if not description.robots:
        composer = _Composer(description, None, gripper_action, period)
        for arm in own_arms(description.model):
            parts += composer.own_pieces(arm)
        if not parts:
            parts += composer.lone_gripper()
    if not parts:
        return []
    path = find_package("tool0_description") / "config" / _FILE
    texts = [read_part(path)]
    if description.cell is not None and description.cell.namespaces:
        texts = [
            _Composer(description, robot, gripper_action, period).joint_states(texts[0])
            for robot in description.robots
        ]
    location = SourceLocation(path, 1)
    return [*(_Piece(text=text, location=location) for text in texts), *parts]


@final
@dataclass(frozen=True, slots=True)
class _Composer:
    """Creates the parts of one robot."""

    description: RobotDescription
    robot: CatalogueRobot | None
    """The catalogue robot; None for a robot file of the user, in which names have no
    prefix."""
    gripper_action: bool
    period: float

    def pieces(self) -> Iterator[_Piece]:
        """Yield the parts of a catalogue arm and its gripper."""
        model, robot = self.description.model, self.robot
        assert robot is not None
        own = self._own_file()
        if own is not None:
            yield self._own_piece(own)
            return
        arm = [robot.prefix + joint for joint in CATALOGUE_JOINTS]
        kind = common_interface(model, arm, _BY_PREFERENCE) or Interface.EFFORT
        path = part_file("arm", robot.arm, _FILES[kind])
        gains, limits = self._arm_rows(arm)
        yield _Piece(
            text=renamed(self.description, robot, read_part(path)),
            location=SourceLocation(path, 1),
            gains=gains if kind is Interface.EFFORT else (),
            limits=limits,
        )
        hand = joints_beyond(model, arm[-1])
        if robot.gripper and hand:
            yield self._gripper(hand, kind)

    def own_pieces(self, arm: OwnArm) -> Iterator[_Piece]:
        """Yield the parts of an arm and its gripper in a robot file of the user.

        The result is empty if velocity is the only interface that the joints have in
        common.
        """
        model = self.description.model
        kind = common_interface(model, arm.joints, _BY_PREFERENCE)
        if kind is None:
            return
        path = part_file("arm", None, _FILES[kind])
        gains, limits = self._arm_rows(arm.joints)
        yield _Piece(
            text=arm.written(read_part(path)),
            location=SourceLocation(path, 1),
            gains=gains if kind is Interface.EFFORT else (),
            limits=limits,
        )
        for piece in self._own_gripper(joints_beyond(model, arm.joints[-1])):
            yield replace(piece, text=arm.written(piece.text))

    def lone_gripper(self) -> Iterator[_Piece]:
        """Yield the part of the gripper in a robot file without an arm."""
        yield from self._own_gripper([g.joint for g in self.description.model.grippers])

    def _own_gripper(self, joints: Sequence[str]) -> Iterator[_Piece]:
        """Yield the part of a gripper that one joint drives, in a user's robot file."""
        kind = common_interface(self.description.model, joints, _BY_PREFERENCE)
        if len(joints) == 1 and kind is not None:
            yield self._gripper(joints, kind)

    def joint_states(self, text: str) -> str:
        """Return the YAML of a joint_state_controller for the joints of one robot."""
        assert self.robot is not None
        model = self.description.model
        driven = model.transmission_by_joint
        joints = [j for j in joints_of(model, self.robot.name) if j in driven]
        text = renamed(self.description, self.robot, text)
        return f"{text}  joints: [{', '.join(sorted(joints))}]\n"

    def _own_file(self) -> Path | None:
        """Return the controllers file that the cell file specifies for the robot."""
        cell, robot = self.description.cell, self.robot
        for item in cell.robots if cell and robot else ():
            if robot and item.name == robot.name and item.controllers_file:
                return expanded(item.controllers_file)
        return None

    def _own_piece(self, path: Path) -> _Piece:
        """Return a controllers file without the entries that a cell shares."""
        text = read_part(path)
        tree = Tree()
        tree.load(text, SourceLocation(path, 1))
        prefix = self.robot.prefix if self.robot else ""
        limits = [
            Row(
                joint=prefix + name,
                values=_flow(entry),
                comment=f"{path.name}:{entry.location.line}",
                location=entry.location,
            )
            for name, entry in _children(tree, LIMITS).items()
        ]
        for key in (_STATE_CONTROLLER, LIMITS):
            text = _without(text, tree, key)
        location = SourceLocation(path, 1)
        return _Piece(
            text=renamed(self.description, self.robot, text),
            location=location,
            limits=limits,
        )

    def _arm_rows(self, joints: Sequence[str]) -> tuple[list[Row], list[Row]]:
        """Return an arm's gains, and the limits of joints with derived gains."""
        stated = self._stated(self.robot.arm if self.robot else None, joints)
        if all(joint in stated for joint in joints):
            return [stated[joint] for joint in joints], []
        from tool0.control.gains import derive_arm_gains

        payload = rating(self.robot.arm, "payload") if self.robot else None
        model = self.description.model
        derived = derive_arm_gains(model, joints, payload, period=self.period)
        gains, limits = [], []
        for joint, found in zip(joints, derived, strict=True):
            if joint in stated:
                gains.append(stated[joint])
                continue
            gains.append(self._derived(joint, found))
            limits.append(limits_row(self.description, joint, found))
        return gains, limits

    def _gripper(
        self, joints: Sequence[str], kind: Interface = Interface.EFFORT
    ) -> _Piece:
        """Return the part of a gripper that ``joints`` drive."""
        if self.gripper_action and kind is not Interface.EFFORT:
            raise ConfigError(
                "gripper_action: the built-in GripperActionController commands "
                f"efforts, and '{joints[0]}' has {kind.value}; leave it out, or "
                "give controllers of your own"
            )
        part = self.robot.gripper if self.robot else None
        model = self.description.model
        by_effort = _ACTION_FILE if self.gripper_action else _FILE
        path = part_file(
            "gripper", part, by_effort if kind is Interface.EFFORT else _FILES[kind]
        )
        stated = self._stated(part, joints)
        rows = []
        for joint in joints if kind is Interface.EFFORT else ():
            if joint not in stated:
                from tool0.control.gains import derive_gripper_gains

                found = derive_gripper_gains(model, joint, period=self.period)
            rows.append(stated.get(joint) or self._derived(joint, found))
        driven = model.joint(joints[0])
        values = {
            **(_LINEAR if driven.type is JointType.PRISMATIC else _ROTARY),
            "$joints": ", ".join(joints),
            "$joint": joints[0],
            "$effort": number_text(driven.limits.effort),
        }
        text = renamed(self.description, self.robot, read_part(path))
        for name, value in values.items():
            text = text.replace(name, value)
        return _Piece(text=text, location=SourceLocation(path, 1), gains=rows)

    def _derived(self, joint: str, gains: DerivedGains) -> Row:
        p, i, d = map(number_text, (gains.p, gains.i, gains.d))
        values = f"p: {p}, i: {i}, d: {d}"
        if gains.i:
            values += f", i_clamp: {number_text(gains.i_clamp)}, antiwindup: true"
        return Row(
            joint=joint,
            values=f"{{{values}}}",
            comment=gains.derivation,
            location=SourceLocation(self.description.source),
        )

    def _stated(
        self, part: CataloguePart | None, joints: Sequence[str]
    ) -> dict[str, Row]:
        """Return the gains that a part's folder specifies, by joint."""
        path = None if part is None else part.file("gains.yaml")
        if self.robot is None or path is None or not path.is_file():
            return {}
        file = Namespace(read_verbatim(path).root)
        file.only("source", "gains")
        source, gains = file.text("source"), file.namespace("gains")
        if gains is None:
            return {}
        prefix = self.robot.prefix
        gains.only(*(joint.removeprefix(prefix) for joint in joints))
        return {
            prefix + name: Row(
                joint=prefix + name,
                values=_flow(entry),
                comment=source,
                location=entry.location,
            )
            for name, entry in gains.entry.children.items()
        }


def _children(tree: Tree, key: str) -> Mapping[str, YamlEntry]:
    entry = tree.root.children.get(key)
    return {} if entry is None else entry.children


def _without(text: str, tree: Tree, key: str) -> str:
    """Return the YAML text with empty lines in place of a top-level ``key``."""
    starts = [entry.location.line or 1 for entry in tree.root.children.values()]
    entry = tree.root.children.get(key)
    if entry is None:
        return text
    lines = text.splitlines(keepends=True)
    first = entry.location.line or 1
    end = min((line for line in starts if line > first), default=len(lines) + 1)
    lines[first - 1 : end - 1] = ["\n"] * (end - first)
    return "".join(lines)


def _flow(entry: YamlEntry) -> str:
    """Return the value of an entry as one line of YAML."""
    if entry.is_mapping:
        items = (f"{name}: {_flow(value)}" for name, value in entry.children.items())
        return f"{{{', '.join(items)}}}"
    value = entry.plain()
    if isinstance(value, int | float) and not isinstance(value, bool):
        return number_text(float(value))
    return json.dumps(value)
