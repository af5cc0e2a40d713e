"""The arms and grippers of a robot, by the names that are used in the API.

A part is named after the prefix of its links, such as ``left`` for an arm that ends at
``left_tool0`` and for a gripper called ``left_gripper``.  Parts without a prefix are
called ``arm`` and ``gripper``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, TypeVar

from tool0.description.model import (
    FLANGE,
    Joint,
    JointType,
    ParallelGripper,
    RobotModel,
)
from tool0.errors import ControlError, did_you_mean

Item = TypeVar("Item")

ARM_JOINTS = 6
_GRIPPER = "gripper"


class ArmParts(NamedTuple):
    """An arm: a chain of six revolute joints that ends at a link ``…tool0``."""

    flange: str
    """Name of the link at the end of the arm."""
    joints: tuple[Joint, ...]
    """The six joints, from base to flange."""


def find_arms(model: RobotModel) -> dict[str, ArmParts]:
    """Return the arms of a robot by name.

    An arm is a chain of six revolute joints and a link at its end with a name that ends
    in ``tool0``.  The chain can also contain fixed joints.
    """
    found = []
    for flange in model.flanges:
        joints = _joints_above(model, flange)
        if joints is not None:
            found.append((flange, ArmParts(flange, joints)))
    return _named(found, FLANGE, "arm")


def arm_joints(model: RobotModel) -> dict[str, tuple[str, ...]]:
    """Return the joints of each arm, from base to flange, by the arm's prefix."""
    return {
        parts.flange.removesuffix(FLANGE): tuple(joint.name for joint in parts.joints)
        for parts in find_arms(model).values()
    }


def find_grippers(model: RobotModel) -> dict[str, ParallelGripper]:
    """Return the parallel grippers of a robot by name."""
    return _named(((item.name, item) for item in model.grippers), _GRIPPER, _GRIPPER)


def flange_names(model: RobotModel) -> dict[str, str]:
    """Return the links ``…tool0`` by name, whether or not an arm ends at the link."""
    return _named(((flange, flange) for flange in model.flanges), FLANGE, "arm")


def joints_of(model: RobotModel, robot: str) -> tuple[str, ...]:
    """Return the movable joints of an arm and of its tools, starting at the base.

    Raises:
        ControlError: If there is no arm of this name.
    """
    arms = find_arms(model)
    if robot not in arms:
        raise ControlError(f"no robot '{robot}'{did_you_mean(robot, set(arms))}")
    links = set(model.links_from(arms[robot].joints[0].child))
    return tuple(joint.name for joint in model.movable_joints if joint.child in links)


def gripper_of(model: RobotModel, robot: str) -> str | None:
    """Return the name of the gripper on an arm, or None if the arm has no gripper.

    Raises:
        ControlError: If there is no arm of this name.
    """
    joints = joints_of(model, robot)
    grippers = find_grippers(model).items()
    return next((name for name, item in grippers if item.joint in joints), None)


def base_of(model: RobotModel, robot: str) -> str:
    """Return the first link below the root that carries only this arm.

    Raises:
        ControlError: If there is no arm of this name.
    """
    arms = find_arms(model)
    if robot not in arms:
        raise ControlError(f"no robot '{robot}'{did_you_mean(robot, set(arms))}")
    others = {arm.flange for name, arm in arms.items() if name != robot}
    base = arms[robot].joints[0].parent
    while (joint := model.parent_joint.get(base)) and joint.parent != model.root:
        if others.intersection(model.links_from(joint.parent)):
            break
        base = joint.parent
    return base


def joints_of_robot(
    model: RobotModel, positions: Mapping[str, float], robot: str | None
) -> dict[str, float]:
    """Return the positions of one robot's joints, or of all joints if no name is given.

    Raises:
        ControlError: If there is no robot of this name, or ``positions`` contains none
            of its joints.
    """
    if robot is None:
        return dict(positions)
    joints = joints_of(model, robot)
    found = {name: positions[name] for name in joints if name in positions}
    if not found:
        raise ControlError(f"the pose has no joint of robot '{robot}'")
    return found


def gripper_joints(model: RobotModel) -> frozenset[str]:
    """Return the movable joints of all grippers and of all other tools on arms."""
    flanges = [arm.flange for arm in find_arms(model).values()]
    carried = {link for flange in flanges for link in model.links_from(flange)}
    tools = {joint.name for joint in model.movable_joints if joint.child in carried}
    return frozenset(tools.union(gripper.joint for gripper in model.grippers))


def _named(
    items: Iterable[tuple[str, Item]], ending: str, alone: str
) -> dict[str, Item]:
    """Return items by the prefix before ``ending``; ``alone`` replaces an empty prefix.

    If two items have the same short name, the second item is returned by its full name.
    """
    named: dict[str, Item] = {}
    for full, item in items:
        name = full.removesuffix(ending).rstrip("_-/") or alone
        named[full if name in named else name] = item
    return named


def _joints_above(model: RobotModel, link: str) -> tuple[Joint, ...] | None:
    """Return the six nearest joints above ``link``, base first, if all are revolute."""
    found: list[Joint] = []
    while len(found) < ARM_JOINTS and (joint := model.parent_joint.get(link)):
        if joint.is_movable:
            turns = joint.type in {JointType.REVOLUTE, JointType.CONTINUOUS}
            if not turns or joint.mimic is not None:
                return None
            found.append(joint)
        link = joint.parent
    return tuple(found[::-1]) if len(found) == ARM_JOINTS else None
