"""Drives for a ROS 2 robot file whose ``<ros2_control>`` tag is in another package.

In published descriptions of this kind, the robot file describes only the arm, and the
driver's package adds the ``<ros2_control>`` tag.
"""

from __future__ import annotations

import logging
from html import escape
from xml.dom.minidom import Document, Element

from tool0.description.xml_source import children, locate, parse_text

logger = logging.getLogger(__name__)

PLUGIN = "tool0/AssumedDrives"
"""Driver's plugin name in the added ``<ros2_control>`` tag."""
_DRIVABLE = ("revolute", "continuous", "prismatic")
_COMMANDS = ("position", "velocity", "effort")


def assume_drives(document: Document) -> None:
    """Add a ``<ros2_control>`` tag that drives all joints, if the file has no drives.

    The added tag does not contain mimic joints.  A document that contains a
    ``<ros2_control>`` or ``<transmission>`` tag is not changed.
    """
    robot = document.documentElement
    if robot is None or _has(robot, "ros2_control") or _has(robot, "transmission"):
        return
    joints = [
        joint.getAttribute("name")
        for joint in children(robot, "joint")
        if joint.getAttribute("type") in _DRIVABLE and not _has(joint, "mimic")
    ]
    if not joints:
        return
    place = locate(robot)
    text = _control(robot.getAttribute("name"), joints)
    added = parse_text(text, place.file if place else None).documentElement
    assert added is not None
    robot.appendChild(added)
    logger.warning(
        "%s: no <ros2_control> tag says how the joints are driven; all %d are, by "
        "position, velocity or effort",
        place,
        len(joints),
    )


def _has(element: Element, tag: str) -> bool:
    return next(children(element, tag), None) is not None


def _control(name: str, joints: list[str]) -> str:
    commands = "".join(f'<command_interface name="{kind}"/>' for kind in _COMMANDS)
    states = "".join(f'<state_interface name="{kind}"/>' for kind in _COMMANDS)
    inside = "".join(
        f'<joint name="{escape(joint)}">{commands}{states}</joint>' for joint in joints
    )
    return (
        f'<ros2_control name="{escape(name)}" type="system"><hardware>'
        f"<plugin>{PLUGIN}</plugin></hardware>{inside}</ros2_control>"
    )
