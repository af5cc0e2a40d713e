"""What a robot holds, as plain values: also of a robot that is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import final
from xml.dom.minidom import Element

from tool0.description.xml_source import LocatedElement, children, text_of
from tool0.errors import SourceLocation
from tool0.lint.robot.elements import attribute, child, child_text, number, place
from tool0.lint.robot.interfaces import InterfaceFacts, meant_interface

CONTROL_PLUGIN = "gazebo_ros_control"
MOVABLE = ("revolute", "continuous", "prismatic", "planar", "floating")
_APART = ("preserveFixedJoint", "disableFixedJointLumping")
_TRUE = ("true", "1")
DRIVABLE = ("revolute", "continuous", "prismatic")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class LimitFacts:
    """A joint's <limit>; None is what is missing or no number."""

    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    location: SourceLocation


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointFacts:
    """One joint; an empty text is what is not written."""

    name: str
    type: str
    parent: str
    child: str
    limits: LimitFacts | None
    mimic_of: str | None
    location: SourceLocation

    @property
    def is_movable(self) -> bool:
        """Whether its type lets it move."""
        return self.type in MOVABLE

    @property
    def is_drivable(self) -> bool:
        """Whether one motor can drive it: it has one axis and mimics no other."""
        return self.type in DRIVABLE and self.mimic_of is None


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TransmissionFacts:
    """One <transmission>, as ROS 1 reads it."""

    name: str
    type: str
    joints: tuple[str, ...]
    interfaces: tuple[InterfaceFacts, ...]
    """The first is the one that counts."""
    n_actuators: int
    location: SourceLocation


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PluginFacts:
    """One <plugin> of Gazebo."""

    filename: str
    name: str
    parameters: tuple[tuple[str, str, SourceLocation], ...]
    """Name, text and place of each element inside."""
    location: SourceLocation

    def parameter(self, name: str) -> str | None:
        """Return the text of the parameter; None if it is not there."""
        return next((text for key, text, _ in self.parameters if key == name), None)

    @property
    def is_control(self) -> bool:
        """Whether it is ROS 1's controller manager for Gazebo classic."""
        return CONTROL_PLUGIN in self.filename

    @property
    def is_control_of_ros2(self) -> bool:
        """Whether it is a controller manager of ROS 2."""
        return "ros2_control" in self.filename

    @property
    def is_mimic(self) -> bool:
        """Whether it moves one joint as another moves."""
        return "mimic" in self.filename


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GearboxFacts:
    """A gearbox joint in a <gazebo> extension, which holds two bodies together."""

    name: str
    parent: str
    child: str
    location: SourceLocation


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RobotFacts:
    """One <robot>.  Of links and joints with one name, the first counts."""

    file: Path | None
    name: str
    links: Mapping[str, SourceLocation]
    joints: Mapping[str, JointFacts]
    transmissions: tuple[TransmissionFacts, ...] = ()
    plugins: tuple[PluginFacts, ...] = ()
    gearboxes: tuple[GearboxFacts, ...] = ()
    ros2_joints: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Joints of <ros2_control>, with their command interfaces."""
    passive_joints: frozenset[str] = frozenset()
    """Joints that need no gearbox since a loop holds them: tool0's <passive_joint>."""
    unmerged: frozenset[str] = frozenset()
    """Fixed joints whose links Gazebo does not merge."""
    has_extensions: bool = False
    """Whether there is any <gazebo>."""

    @property
    def control_plugins(self) -> tuple[PluginFacts, ...]:
        """The plugins that are ROS 1's controller managers."""
        return tuple(plugin for plugin in self.plugins if plugin.is_control)

    @property
    def mimic_plugin_joints(self) -> frozenset[str]:
        """The joints that a plugin moves as another moves."""
        return frozenset(
            plugin.parameter("mimicJoint") or ""
            for plugin in self.plugins
            if plugin.is_mimic
        )

    @property
    def plugin_joints(self) -> frozenset[str]:
        """What plugins name: among it the joints that they move."""
        return frozenset(
            text for plugin in self.plugins for _, text, _ in plugin.parameters
        )

    def moves(self, joint: JointFacts) -> bool:
        """Return whether ``joint`` joins two bodies: a fixed one makes them one."""
        return joint.is_movable or joint.name in self.unmerged

    @property
    def driven_joints(self) -> frozenset[str]:
        """The joints that a controller can command, in ROS 1 or 2."""
        commanded = {name for name, kinds in self.ros2_joints.items() if kinds}
        by_transmissions = (name for item in self.transmissions for name in item.joints)
        return frozenset(commanded.union(by_transmissions))

    def interfaces_of(self, joint: str) -> tuple[InterfaceFacts, ...]:
        """Return the interfaces of ``joint``; the first is the one that counts."""
        return tuple(
            interface
            for transmission in self.transmissions
            if joint in transmission.joints
            for interface in transmission.interfaces
        )


def facts_of(root: LocatedElement | Element) -> RobotFacts:
    """Return what ``root``, a <robot>, holds."""
    extensions = list(children(root, "gazebo"))
    links: dict[str, SourceLocation] = {}
    for element in children(root, "link"):
        links.setdefault(attribute(element, "name"), place(element))
    joints: dict[str, JointFacts] = {}
    for element in children(root, "joint"):
        joints.setdefault(attribute(element, "name"), _joint(element))
    links.pop("", None)
    joints.pop("", None)
    return RobotFacts(
        file=place(root).file,
        name=attribute(root, "name"),
        links=links,
        joints=joints,
        transmissions=tuple(
            _transmission(element)
            for element in children(root, "transmission")
            if not element.hasAttribute("type")  # that of a PR2, not of ros_control
        ),
        plugins=tuple(
            _plugin(element)
            for extension in extensions
            for element in children(extension, "plugin")
        ),
        gearboxes=tuple(_gearboxes(extensions)),
        ros2_joints=_ros2_joints(root),
        passive_joints=frozenset(
            attribute(element, "name") for element in children(root, "passive_joint")
        ),
        unmerged=frozenset(
            attribute(extension, "reference")
            for extension in extensions
            if any(child_text(extension, flag).lower() in _TRUE for flag in _APART)
        ),
        has_extensions=bool(extensions),
    )


def _joint(element: Element) -> JointFacts:
    limit = child(element, "limit")
    mimic = child(element, "mimic")
    return JointFacts(
        name=attribute(element, "name"),
        type=attribute(element, "type"),
        parent=attribute(child(element, "parent"), "link"),
        child=attribute(child(element, "child"), "link"),
        limits=None if limit is None else _limits(limit),
        mimic_of=None if mimic is None else attribute(mimic, "joint"),
        location=place(element),
    )


def _limits(element: Element) -> LimitFacts:
    return LimitFacts(
        lower=number(element, "lower"),
        upper=number(element, "upper"),
        velocity=number(element, "velocity"),
        effort=number(element, "effort"),
        location=place(element),
    )


def _transmission(element: Element) -> TransmissionFacts:
    joints = list(children(element, "joint"))
    actuators = list(children(element, "actuator"))
    return TransmissionFacts(
        name=attribute(element, "name"),
        type=child_text(element, "type"),
        joints=tuple(attribute(joint, "name") for joint in joints),
        interfaces=tuple(
            InterfaceFacts(
                written=text_of(named),
                meant=meant_interface(text_of(named)),
                in_actuator=owner.tagName == "actuator",
                location=place(named),
            )
            for owner in (*joints, *actuators)
            for named in children(owner, "hardwareInterface")
        ),
        n_actuators=len(actuators),
        location=place(element),
    )


def _plugin(element: Element) -> PluginFacts:
    return PluginFacts(
        filename=attribute(element, "filename"),
        name=attribute(element, "name"),
        parameters=tuple(
            (item.tagName, text_of(item), place(item)) for item in children(element)
        ),
        location=place(element),
    )


def _gearboxes(extensions: list[Element]) -> Iterator[GearboxFacts]:
    for extension in extensions:
        for element in children(extension, "joint"):
            if attribute(element, "type") == "gearbox":
                yield GearboxFacts(
                    name=attribute(element, "name"),
                    parent=child_text(element, "parent"),
                    child=child_text(element, "child"),
                    location=place(element),
                )


def _ros2_joints(root: Element) -> dict[str, tuple[str, ...]]:
    return {
        attribute(joint, "name"): tuple(
            attribute(item, "name") for item in children(joint, "command_interface")
        )
        for system in children(root, "ros2_control")
        for joint in children(system, "joint")
    }
