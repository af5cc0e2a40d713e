"""Checks the syntax, indentation and controllers of YAML text."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import final

from tool0.control.config import ControllerConfig
from tool0.control.joint_limits import joint_limit_parameters
from tool0.control.ros1.dialect import ROS1
from tool0.control.ros1.lint import gain_parameters
from tool0.description.finding import Finding, error_at
from tool0.description.yaml_tree import Tree, require_yaml
from tool0.errors import ConfigError, SourceLocation
from tool0.lint.packages import Packages
from tool0.lint.parameters import ros1, ros2
from tool0.lint.plugins import PluginIndex
from tool0.lint.robot.facts import RobotFacts

_NONE: Packages = MappingProxyType({})
_KEY = re.compile(r"^( *)([\w/.*-]+) *:(?: *| +[&!]\S+ *)(?:#.*)?$")
"""Pattern of a key without a value on the same line."""
_ANY = re.compile(r"^( *)([\w/.*-]+) *:")
_OPENCV = "%YAML:"
"""First characters of an OpenCV file, which is not standard YAML."""
_MARKS = re.compile(
    r"(?:^|[{,])[ \t]*(?:[\w/*]*type *: *['\"]?[\w]+/\w*(?:Controller|Broadcaster)\b"
    r"|[\w/]*pid_gains *:|gazebo_ros_control *:|ros_+parameters? *:"
    r"|controller_manager *:)",
    re.MULTILINE,
)
"""Pattern of text that occurs only in files with controllers.  The text is found even
if the file is faulty."""


@final
@dataclass(frozen=True, slots=True)
class YamlText:
    """YAML text and the location of its first line."""

    text: str
    location: SourceLocation

    @property
    def is_about_controllers(self) -> bool:
        """Whether the text contains parameters of ros_control or ros2_control."""
        return _MARKS.search(self.text) is not None


def yaml_findings(
    texts: Iterable[YamlText],
    robot: RobotFacts | None = None,
    packages: Packages = _NONE,
    started: Collection[str] = (),
) -> Iterator[Finding]:
    """Yield the faults of controllers in YAML texts that are loaded together.

    Args:
        texts: Texts in the order in which they are loaded.  Later texts override
            earlier texts.
        robot: The robot that the controllers command, if it is known.
        packages: Packages of the workspace, which may export controller types.
        started: The controllers that a launch file starts, if they are known.
    """
    trees: list[YamlText] = []
    for text in texts:
        flat = list(_flat_findings(text.text, text.location))
        yield from flat
        meant = YamlText(_restored(text.text), text.location) if flat else text
        try:
            Tree().load(meant.text, meant.location)
        except ConfigError as error:
            yield _not_yaml(error, text)
            continue
        trees.append(meant)
    if not any(text.is_about_controllers for text in trees):
        return
    whole = Tree()
    for text in trees:
        whole.load(text.text, text.location)
    if ros2.is_ros2(whole.root):
        yield from ros2.controller_findings(whole, robot, PluginIndex(packages))
    else:
        config = ControllerConfig(whole)
        yield from ros1.controller_findings(
            config, robot, PluginIndex(packages), started
        )


def syntax_findings(text: YamlText) -> Iterator[Finding]:
    """Yield a finding if the text cannot be parsed, whatever its content is."""
    if text.text.startswith(_OPENCV):
        return
    try:
        require_yaml(text.text, text.location)
    except ConfigError as error:
        yield _not_yaml(error, text)


def _not_yaml(error: ConfigError, text: YamlText) -> Finding:
    return error_at(
        error.location or text.location,
        "not-yaml",
        "",
        error.message,
        "check quotes, colons and indentation there",
    )


def _flat_findings(text: str, first: SourceLocation) -> Iterator[Finding]:
    """Yield a finding if keys are at the level of their parent instead of below it.

    Args:
        text: YAML text, which may be faulty.
        first: Location of the text's first line.
    """
    found = list(_flat_keys(text))
    if not found:
        return
    row, key, inside = found[0]
    others = len(found) - 1
    more = f" ({others} more like it below)" if others else ""
    yield error_at(
        SourceLocation(first.file, (first.line or 1) + row),
        "flat-yaml",
        key,
        f"is empty, since '{inside}' after it is not indented: its parameters "
        f"are at its level, where nothing reads them{more}",
        f"indent what belongs to '{key}' by two spaces",
    )


@cache
def _inner_keys() -> frozenset[str]:
    """Return the keys that always occur below another key, never at the top level."""
    inner = {
        key.split("/")[0] for name in ROS1.types for key in ROS1.parameters_of(name)
    }
    inner |= gain_parameters() | joint_limit_parameters()
    inner |= {"type", "pid_gains", "trajectory", "goal", "goal_time"}
    inner |= {"ros__parameters", "command_interfaces", "state_interfaces"}
    return frozenset(inner - {"*"})


def _restored(text: str) -> str:
    """Return YAML text in which lost indentation is restored."""
    flat = {row for row, _, _ in _flat_keys(text)}
    around: list[int] = []  # indents of the keys below which lines are moved
    lines = []
    for row, line in enumerate(text.splitlines()):
        match = _ANY.match(line)
        if match is not None:
            indent = len(match[1])
            while around and (
                indent < around[-1]
                or (indent == around[-1] and match[2] not in _inner_keys())
            ):
                around.pop()
        lines.append("  " * len(around) + line)
        if row in flat and match is not None:
            around.append(len(match[1]))
    return "\n".join(lines) + "\n"


def _flat_keys(text: str) -> Iterator[tuple[int, str, str]]:
    """Yield each key that lost its contents, with the key's row and the next key."""
    empty: tuple[int, str, str] | None = None
    for row, line in enumerate(text.splitlines()):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if empty is not None and (match := _ANY.match(line)) is not None:
            before, indent, key = empty
            if (
                match[1] == indent
                and match[2] in _inner_keys()
                and key not in _inner_keys()
            ):
                yield before, key, match[2]
        match = _KEY.match(line)
        empty = None if match is None else (row, match[1], match[2])
