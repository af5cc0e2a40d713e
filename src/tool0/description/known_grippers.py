"""Grippers in published robot files, recognized by the name of the driven joint.

The files of other projects do not contain the element ``<parallel_gripper>``, which
relates the opening to the joint's position.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Final
from xml.dom.minidom import Document, Element

from tool0.description.model import ParallelGripper, RotaryOpening
from tool0.description.xml_source import children, locate, number, only_child

logger = logging.getLogger(__name__)

_JOINTS: Final = (
    "robotiq_85_left_knuckle_joint",
    "robotiq_140_left_knuckle_joint",
    "finger_joint",
)
"""Names, without prefix, of the driven joints in the descriptions of ros-industrial and
PickNik."""
_OF_140: Final = 0.72
"""A gripper whose upper joint limit is below this value is a 2F-140 [rad].  A 2F-85 is
closed at 0.8 rad."""


def add_known_grippers(
    document: Document, catalogue: Callable[[str], ParallelGripper]
) -> None:
    """Add ``<parallel_gripper>`` for known grippers, if the file has no such element.

    ``catalogue`` is a function that returns the built-in gripper with a given name.
    """
    robot = document.documentElement
    if robot is None or _has(robot, "parallel_gripper"):
        return
    for joint in children(robot, "joint"):
        name = joint.getAttribute("name")
        ending = next((item for item in _JOINTS if name.endswith(item)), None)
        limit = only_child(joint, "limit")
        is_known = ending is not None and joint.getAttribute("type") == "revolute"
        if ending is None or limit is None or not is_known:
            continue
        if _has(joint, "mimic"):
            continue
        is_140 = "140" in name or number(limit, "upper", 0.0) < _OF_140
        model = "2f140" if is_140 else "2f85"
        element = document.createElement("parallel_gripper")
        prefix = name.removesuffix(ending)
        values = _values(catalogue(model)) | {"name": f"{prefix}gripper", "joint": name}
        for key, value in values.items():
            element.setAttribute(key, value)
        robot.appendChild(element)
        logger.info(
            "%s: '%s' is taken for the joint of a %s",
            locate(joint),
            name,
            model.upper(),
        )


def _has(element: Element, tag: str) -> bool:
    """Return whether an element has a child called ``tag``."""
    return next(children(element, tag), None) is not None


def _values(gripper: ParallelGripper) -> dict[str, str]:
    """Return the ``<parallel_gripper>`` attributes of a gripper with a rotary joint."""
    law = gripper.law
    assert isinstance(law, RotaryOpening)
    numbers = {
        "pad_offset": law.pad_offset,
        "pad_cos": law.pad_cos,
        "pad_sin": law.pad_sin,
        "max_opening": gripper.max_opening,
        "min_speed": gripper.speed[0],
        "max_speed": gripper.speed[1],
        "min_force": gripper.force[0],
        "max_force": gripper.force[1],
    }
    texts = {key: repr(value) for key, value in numbers.items()}
    return texts if gripper.protocol is None else texts | {"protocol": gripper.protocol}
