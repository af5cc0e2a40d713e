"""The content of a robot as plain values.  The robot may be faulty."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.description.model import Interface
from tool0.description.ros2_control import command_interfaces
from tool0.errors import SourceLocation, nearest_name
from tool0.lint.packages import PackageIndex
from tool0.lint.robot.elements import Subject, Tag

MOVABLE = ("revolute", "continuous", "prismatic", "planar", "floating")
_DRIVABLE = ("revolute", "continuous", "prismatic")
_APART = ("preserveFixedJoint", "disableFixedJointLumping")
_TRUE = ("true", "1")

_PACKAGE = "hardware_interface/"
_NAMES = {item.value.removeprefix(_PACKAGE): item.value for item in Interface}
_INTERFACES = (
    *_NAMES.values(),
    _PACKAGE + "JointStateInterface",
    _PACKAGE + "PosVelJointInterface",
    _PACKAGE + "PosVelAccJointInterface",
)
"""Interfaces that ``DefaultRobotHWSim`` drives, or that a robot's own driver may
drive."""
_LONGEST = 100


def is_interface(text: str) -> bool:
    """Return whether ROS has the interface ``text``, with or without its package."""
    return text in _INTERFACES or _PACKAGE + text in _INTERFACES


def meant_interface(text: str) -> str | None:
    """Return the interface that ``text`` names or misspells, or None."""
    bare = text.strip().strip("\"'").strip()
    if len(bare) > _LONGEST:
        return None
    name = re.split(r"[/\\:.]+", bare)[-1]
    for known in _INTERFACES:
        if known == bare or known.removeprefix(_PACKAGE) == name:
            return known
    close = nearest_name(name, _NAMES, cutoff=0.8)
    return _NAMES[close] if close else nearest_name(bare, _NAMES.values(), cutoff=0.8)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointFacts:
    """Content of one joint.  Missing values are empty texts."""

    at: Subject
    type: str
    parent: str
    child: str
    has_limits: bool
    mimic_of: str | None

    @property
    def name(self) -> str:
        return self.at.key

    @property
    def is_movable(self) -> bool:
        """Whether a joint of this type can move."""
        return self.type in MOVABLE

    @property
    def is_drivable(self) -> bool:
        """Whether one motor can drive the joint.

        One motor can drive a joint that has one axis and mimics no other joint.
        """
        return self.type in _DRIVABLE and self.mimic_of is None


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class InterfaceFacts:
    """One <hardwareInterface>."""

    at: Subject
    meant: str | None
    """Interface, in the form ``hardware_interface/…``; None if it is unclear."""
    in_actuator: bool
    """Whether the interface is written in <actuator>.  An interface in <actuator> is
    deprecated.  ROS reads an interface in <actuator> only if <joint> names no
    interface."""

    @property
    def written(self) -> str:
        return self.at.key


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TransmissionFacts:
    """One <transmission>, in the form in which ROS 1 reads it."""

    at: Subject
    type: str
    joints: tuple[str, ...]
    interfaces: tuple[InterfaceFacts, ...]
    """All interfaces.  Only the first interface applies."""
    n_actuators: int


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PluginFacts:
    """One <plugin> of Gazebo."""

    at: Subject
    filename: str
    parameters: tuple[tuple[Subject, str], ...]
    """Subject and text of each child element.  The subject's key is the name of the
    element."""

    def parameter(self, name: str) -> str | None:
        """Return the text of a parameter; None if the parameter is missing."""
        return next((text for at, text in self.parameters if at.key == name), None)

    @property
    def is_control(self) -> bool:
        """Whether the plugin is ROS 1's controller manager for Gazebo classic."""
        return "gazebo_ros_control" in self.filename

    @property
    def is_control_of_ros2(self) -> bool:
        """Whether the plugin is a controller manager of ROS 2."""
        return "ros2_control" in self.filename

    @property
    def is_mimic(self) -> bool:
        """Whether the plugin makes one joint follow another."""
        return "mimic" in self.filename


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GearboxFacts:
    """A gearbox joint in a <gazebo> extension, which couples two bodies."""

    at: Subject
    parent: str
    child: str


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RobotFacts:
    """Content of one <robot>.

    If links or joints share a name, the first one is used.
    """

    name: str
    links: Mapping[str, SourceLocation]
    joints: Mapping[str, JointFacts]
    transmissions: tuple[TransmissionFacts, ...] = ()
    plugins: tuple[PluginFacts, ...] = ()
    gearboxes: tuple[GearboxFacts, ...] = ()
    ros2_joints: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Command interfaces of each joint in <ros2_control>, by joint."""
    passive_joints: frozenset[str] = frozenset()
    """Joints that need no gearbox because a closed loop holds them.  These joints are
    declared with tool0's <passive_joint>."""
    unmerged: frozenset[str] = frozenset()
    """Fixed joints at which Gazebo does not merge the two links."""
    has_extensions: bool = False
    """Whether the robot contains a <gazebo> element."""

    @property
    def control_plugins(self) -> tuple[PluginFacts, ...]:
        """Plugins that are controller managers of ROS 1."""
        return tuple(plugin for plugin in self.plugins if plugin.is_control)

    @property
    def driven_joints(self) -> frozenset[str]:
        """Joints that a controller can command in ROS 1 or ROS 2."""
        commanded = {name for name, kinds in self.ros2_joints.items() if kinds}
        by_transmissions = (name for item in self.transmissions for name in item.joints)
        return frozenset(commanded.union(by_transmissions))

    @property
    def movable_joints(self) -> tuple[str, ...]:
        """Names of the joints that are not fixed."""
        return tuple(joint.name for joint in self.joints.values() if joint.is_movable)

    def interfaces_of(self, joint: str) -> tuple[InterfaceFacts, ...]:
        """Return the interfaces of ``joint``.  Only the first interface applies."""
        return tuple(
            interface
            for transmission in self.transmissions
            if joint in transmission.joints
            for interface in transmission.interfaces
        )

    def moves(self, joint: JointFacts) -> bool:
        """Return whether ``joint`` separates two bodies.

        Gazebo merges the links of a fixed joint into one body, unless the joint is in
        ``unmerged``.
        """
        return joint.is_movable or joint.name in self.unmerged

    def bodies(self) -> Mapping[str, str]:
        """Return the first link of the Gazebo body that contains each link, by link."""
        above: dict[str, JointFacts] = {}
        for joint in self.joints.values():
            above.setdefault(joint.child, joint)
        body: dict[str, str] = {}
        for link in self.links:
            path: dict[str, None] = {}
            at = link
            while at not in body and at not in path:
                path[at] = None
                upward = above.get(at)
                if upward is None or self.moves(upward):
                    break
                if upward.parent not in self.links:
                    break
                at = upward.parent
            body.update(dict.fromkeys(path, body.get(at, at)))
        return body


def facts_of(root: Tag) -> RobotFacts:
    """Return the content of the <robot> element ``root``."""
    extensions = list(root.children("gazebo"))
    links: dict[str, SourceLocation] = {}
    for link in root.children("link"):
        links.setdefault(link["name"], link.location)
    joints: dict[str, JointFacts] = {}
    for joint in root.children("joint"):
        joints.setdefault(joint["name"], _joint(joint))
    links.pop("", None)
    joints.pop("", None)
    return RobotFacts(
        name=root["name"],
        links=links,
        joints=joints,
        transmissions=tuple(
            _transmission(item)
            for item in root.children("transmission")
            # a transmission with a type attribute is for the PR2, not for ros_control
            if "type" not in item
        ),
        plugins=tuple(
            _plugin(item)
            for extension in extensions
            for item in extension.children("plugin")
        ),
        gearboxes=tuple(_gearboxes(extensions)),
        ros2_joints=command_interfaces(root.element) if root.element else {},
        passive_joints=frozenset(
            item["name"] for item in root.children("passive_joint")
        ),
        unmerged=frozenset(
            extension["reference"]
            for extension in extensions
            if any(extension.child(flag).text.lower() in _TRUE for flag in _APART)
        ),
        has_extensions=bool(extensions),
    )


def _joint(joint: Tag) -> JointFacts:
    mimic = joint.child("mimic")
    return JointFacts(
        at=joint.at,
        type=joint["type"],
        parent=joint.child("parent")["link"],
        child=joint.child("child")["link"],
        has_limits=bool(joint.child("limit")),
        mimic_of=mimic["joint"] if mimic else None,
    )


def _transmission(item: Tag) -> TransmissionFacts:
    joints, actuators = list(item.children("joint")), list(item.children("actuator"))
    return TransmissionFacts(
        at=item.at,
        type=item.child("type").text,
        joints=tuple(joint["name"] for joint in joints),
        interfaces=tuple(
            InterfaceFacts(
                at=Subject(named.text, named.location),
                meant=meant_interface(named.text),
                in_actuator=owner.tag == "actuator",
            )
            for owner in (*joints, *actuators)
            for named in owner.children("hardwareInterface")
        ),
        n_actuators=len(actuators),
    )


def _plugin(plugin: Tag) -> PluginFacts:
    return PluginFacts(
        at=Subject(plugin["name"], plugin.location),
        filename=plugin["filename"],
        parameters=tuple(
            (Subject(item.tag, item.location), item.text) for item in plugin.children()
        ),
    )


def _gearboxes(extensions: list[Tag]) -> Iterator[GearboxFacts]:
    for extension in extensions:
        for joint in extension.children("joint"):
            if joint["type"] == "gearbox":
                yield GearboxFacts(
                    at=Subject(joint["name"], joint.location),
                    parent=joint.child("parent").text,
                    child=joint.child("child").text,
                )


@final
@dataclass(frozen=True, slots=True)
class Robot:
    """The robot that the rules check, with its XML and its content."""

    root: Tag
    facts: RobotFacts
    body: Mapping[str, str]
    """First link of the Gazebo body that contains each link, by link."""
    packages: PackageIndex
    is_spawned: bool | None
    """Whether the robot is spawned in Gazebo in order to be controlled; None if no
    launch file loads the robot."""

    @property
    def is_controlled(self) -> bool:
        """Whether ROS 1 is expected to control the robot in Gazebo."""
        facts = self.facts
        return bool(facts.transmissions or facts.control_plugins or self.is_spawned)
