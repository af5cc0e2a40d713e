"""Files of other people's packages, changed where they stand.

Source of what is wrong with them: the files themselves, jr-robotics/robotiq@3aab694 and
ros-industrial/universal_robot (noetic).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Final

from tool0.description.finding import Finding
from tool0.errors import SourceLocation
from tool0.lint.xml_comments import blank, comments, inside, without_comments

UPSTREAM: Final = frozenset(
    {
        *("ur_description", "ur_gazebo", "ur_kinematics", "ur_bringup"),
        *("ur3_moveit_config", "ur5_moveit_config", "ur10_moveit_config"),
        *("robotiq_2f_85_gripper_gazebo", "robotiq_2f_85_gripper_visualization"),
        *("robotiq_2f_140_gripper_visualization", "robotiq_gazebo"),
        *("robotiq_description", "robotiq_2f_gripper_control"),
    }
)
"""Packages that people clone and do not own."""
_FOREIGN: Final = {
    "ur_": re.compile(r"robotiq|gripper|finger_joint", re.IGNORECASE),
    "robotiq": re.compile(r"\btool0\b|\bur_(?:gazebo|description)\b"),
}
"""What the files of each never mention as they are published."""
_DO_NOT_EDIT = re.compile(r"do not (?:edit|change) this file", re.IGNORECASE)
_YAML_COMMENT = re.compile(r"#[^\n]*")
_YAML = (".yaml", ".yml")
_WHOLE_ELEMENT = re.compile(
    r"^\s*<([A-Za-z_][\w:.-]*)\b[^>]*(?:/>|>.*</\1\s*>)", re.DOTALL
)
_PARTS = frozenset(
    {
        *("link", "joint", "gazebo", "plugin", "transmission"),
        *("include", "node", "param", "xacro:include"),
    }
)
"""Elements whose absence changes what the file does; those who publish such files leave
others in comments, too."""
KNOWN_FAULTS: Final[Mapping[tuple[str, str], tuple[tuple[str, str], ...]]] = {
    ("robotiq_2f_85_gripper_gazebo", "robotiq_arg2f_85_macro.xacro"): (
        (
            "its macro hard-codes an empty prefix, so that a prefix has no effect and "
            "a second gripper cannot be added",
            'write prefix="${prefix}" there',
        ),
        (
            "its default interface is 'hardware/interface/EffortJointInterface', a "
            "typo that gazebo_ros_control does not know",
            "hand transmission_hw_interface to the macro, or write "
            "hardware_interface/EffortJointInterface",
        ),
        (
            "its mimic plugins have no <hasPID/>, so that Gazebo teleports the fingers "
            "and gains for them are never read",
            "hold them with gearbox joints, as robotiq_2f_85_macro.xacro of "
            "tool0_description does",
        ),
    ),
}
"""Package and file → what is wrong with it as it is published, and what to do."""
_INSTEAD = (
    "put it into a file of your own that includes this one; `tool0 workspace` does"
)


def edit_findings(file: Path, text: str, package: str | None) -> Iterator[Finding]:
    """Yield where a file that belongs to others was changed.

    Args:
        file: The file, for places.
        text: What it holds.
        package: The package it lies in, if any.
    """
    asks = _DO_NOT_EDIT.search(text)
    is_upstream = package in UPSTREAM
    if not is_upstream and asks is None:
        return
    if not is_upstream and package is not None:
        return  # a copy in a package of one's own, as the file asks
    foreign = next(
        (p for prefix, p in _FOREIGN.items() if (package or "ur_").startswith(prefix)),
        None,
    )
    if file.suffix in _YAML:
        bare = _YAML_COMMENT.sub(lambda match: blank(match[0]), text)
    else:
        bare = without_comments(text)
    match = foreign.search(bare) if foreign is not None else None
    if match is not None:
        whose = "that asks not to be edited" if asks else f"of '{package}'"
        yield _finding(
            _place(file, bare, match.start()),
            f"'{match[0]}' was added to a file {whose}: the next update, or the next "
            "person's clone, is without it",
        )
    if not is_upstream:
        return
    for start, end in comments(text):
        element = _WHOLE_ELEMENT.match(inside(text, start, end))
        if element is not None and element[1] in _PARTS:
            yield _finding(
                _place(file, text, start),
                f"<{element[1]}> is commented out in a file of '{package}': the next "
                "update, or the next person's clone, has it again",
            )


def known_findings(
    text: str, first: SourceLocation, is_here: Callable[[str], bool]
) -> Iterator[Finding]:
    """Yield what is wrong with published files that a text includes.

    Args:
        text: The text.
        first: Where its first line stands.
        is_here: Whether a package can be looked into, which tells more.
    """
    bare = without_comments(text)
    for (package, file), faults in KNOWN_FAULTS.items():
        if is_here(package):
            continue
        match = re.search(rf"\$\(find {package}\)/[\w/]*{re.escape(file)}", bare)
        if match is None:
            continue
        for fault, remedy in faults:
            yield Finding(
                location=_within(text, match.start(), first),
                rule="known-fault",
                severity="warning",
                key=file,
                message=f"of {package}: {fault}",
                remedy=remedy,
            )


def _finding(location: SourceLocation, message: str) -> Finding:
    return Finding(
        location=location,
        rule="edited-upstream",
        severity="warning",
        message=message,
        remedy=_INSTEAD,
    )


def _place(file: Path, text: str, offset: int) -> SourceLocation:
    return _within(text, offset, SourceLocation(file, 1))


def _within(text: str, offset: int, first: SourceLocation) -> SourceLocation:
    return SourceLocation(first.file, (first.line or 1) + text.count("\n", 0, offset))
