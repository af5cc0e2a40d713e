"""The SRDF of a robot: planning groups, named states and disabled collisions.

For a single robot, the arm is the group ``manipulator``, and the gripper is the group
``gripper``, as in ur5_moveit_config.  For several robots, the names of the groups
include the robot's name, such as ``left_manipulator``.  The group ``arms`` contains all
arms.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, final
from xml.etree import ElementTree as ET

from tool0.description.catalogue import CataloguePart
from tool0.description.model import FLANGE, RobotModel
from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.errors import DescriptionError

ALL_ARMS: Final = "arms"
"""Name of the group that contains all arms."""
_BASE: Final = "base_link"
"""Name of an arm's first link, without the arm's prefix."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ArmGroup:
    """A group that contains an arm, which is a chain of links."""

    name: str
    base_link: str
    tip_link: str
    joints: tuple[str, ...]
    """Names of the driven joints, from base to tip."""
    states: Mapping[str, Mapping[str, float]]
    """Joint positions [rad] of each pose, by pose and joint."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GripperGroup:
    """A group that contains the links of a gripper and the joint that drives them."""

    name: str
    arm: ArmGroup
    links: tuple[str, ...]
    joints: tuple[str, ...]
    """Names of the driven joints."""
    states: Mapping[str, Mapping[str, float]]
    """Joint positions [rad | m] of each pose, by pose and joint."""


Group = ArmGroup | GripperGroup


def planning_groups(description: RobotDescription) -> tuple[Group, ...]:
    """Return the groups of the robots.  Each arm is followed by its gripper.

    Raises:
        DescriptionError: If the robot is your own description file, which does not
            define arms.
    """
    if not description.robots:
        raise DescriptionError(
            f"'{description.source}' does not say which of its links are an arm; "
            "a MoveIt package is written for arms and grippers of the catalogue"
        )
    return tuple(
        group for robot in description.robots for group in _groups(robot, description)
    )


def _groups(robot: CatalogueRobot, description: RobotDescription) -> Iterator[Group]:
    model, prefix = description.model, robot.prefix
    start = f"{robot.name}_" if robot.name else ""
    base, tip = prefix + _BASE, prefix + FLANGE
    beyond = model.links_from(tip)[1:]
    arm = ArmGroup(
        name=f"{start}manipulator",
        base_link=base,
        tip_link=tip,
        joints=_driven(model, set(model.links_from(base)) - set(beyond)),
        states=_states(robot.arm, prefix),
    )
    yield arm
    if robot.gripper is not None:
        yield GripperGroup(
            name=f"{start}gripper",
            arm=arm,
            links=beyond,
            joints=_driven(model, set(beyond)),
            states=_states(robot.gripper, prefix),
        )


def _driven(model: RobotModel, links: set[str]) -> tuple[str, ...]:
    """Return the names of the driven joints of ``links``."""
    drives = model.transmission_by_joint
    return tuple(j.name for j in model.joints if j.child in links and j.name in drives)


def _states(part: CataloguePart, prefix: str) -> dict[str, dict[str, float]]:
    return {
        name: {prefix + joint: position for joint, position in pose.items()}
        for name, pose in part.load("poses").items()
    }


def arm_groups(groups: Iterable[Group]) -> list[ArmGroup]:
    """Return the groups that are arms."""
    return [group for group in groups if isinstance(group, ArmGroup)]


def to_srdf(
    description: RobotDescription, disabled: Mapping[tuple[str, str], str]
) -> str:
    """Return the SRDF of the robots.

    Args:
        description: The robots.  The root link of the robots is the planning frame, so
            that no virtual joint is needed.
        disabled: Reasons for the pairs of links that are not checked for collisions, by
            pair.
    """
    groups = planning_groups(description)
    robot = ET.Element("robot", name=description.model.name)
    arms = arm_groups(groups)
    for group in groups:
        element = ET.SubElement(robot, "group", name=group.name)
        match group:
            case ArmGroup(base_link=base, tip_link=tip):
                ET.SubElement(element, "chain", base_link=base, tip_link=tip)
            case GripperGroup():
                for link in group.links:
                    ET.SubElement(element, "link", name=link)
    if len(arms) > 1:
        element = ET.SubElement(robot, "group", name=ALL_ARMS)
        for arm in arms:
            ET.SubElement(element, "group", name=arm.name)
    states = [
        (name, group.name, pose)
        for group in groups
        for name, pose in group.states.items()
    ]
    if len(arms) > 1:
        states += [(name, ALL_ARMS, pose) for name, pose in _common(arms)]
    for name, group_name, pose in states:
        state = ET.SubElement(robot, "group_state", name=name, group=group_name)
        for joint, position in pose.items():
            ET.SubElement(state, "joint", name=joint, value=repr(position))
    for group in groups:
        if isinstance(group, GripperGroup):
            ET.SubElement(
                robot,
                "end_effector",
                name=group.name,
                parent_link=group.arm.tip_link,
                group=group.name,
                parent_group=group.arm.name,
            )
    for follower in description.model.movable_joints:
        if follower.mimic is not None:
            ET.SubElement(robot, "passive_joint", name=follower.name)
    for (first, second), reason in sorted(disabled.items()):
        ET.SubElement(
            robot, "disable_collisions", link1=first, link2=second, reason=reason
        )
    ET.indent(robot)
    return f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n'


def _common(arms: list[ArmGroup]) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield the poses that every arm has."""
    for name in arms[0].states:
        if all(name in arm.states for arm in arms):
            yield name, {k: q for arm in arms for k, q in arm.states[name].items()}
