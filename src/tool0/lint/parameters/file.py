"""One YAML: which layout it has, and what is wrong with its controllers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import final

from tool0.control.config import ControllerConfig
from tool0.description.finding import Finding
from tool0.description.yaml_tree import Tree
from tool0.errors import ConfigError, SourceLocation
from tool0.lint.parameters import ros1, ros2
from tool0.lint.parameters.flat import flat_findings, restored
from tool0.lint.robot.facts import RobotFacts

_MARKS = re.compile(
    r"(?:^|[{,])[ \t]*(?:[\w/*]*type *: *['\"]?[\w]+/\w*(?:Controller|Broadcaster)\b"
    r"|[\w/]*pid_gains *:|gazebo_ros_control *:|ros_+parameters? *:"
    r"|controller_manager *:)",
    re.MULTILINE,
)
"""What a file of controllers has, also when something is wrong with it."""


@final
@dataclass(frozen=True, slots=True)
class YamlText:
    """A text of YAML, and where its first line stands."""

    text: str
    location: SourceLocation

    @property
    def is_about_controllers(self) -> bool:
        """Whether it holds parameters of ros_control, of either ROS."""
        return _MARKS.search(self.text) is not None


def yaml_findings(
    texts: Iterable[YamlText], robot: RobotFacts | None = None
) -> Iterator[Finding]:
    """Yield what is wrong with the controllers of texts that are loaded together.

    Args:
        texts: In the order of loading; later ones override.
        robot: The robot that they are for, if it is known.
    """
    trees: list[YamlText] = []
    for text in texts:
        flat = list(flat_findings(text.text, text.location))
        yield from flat
        meant = YamlText(restored(text.text), text.location) if flat else text
        try:
            Tree().load(meant.text, meant.location)
        except ConfigError as error:
            yield Finding(
                location=error.location or text.location,
                rule="not-yaml",
                message=error.message,
                remedy="look at the quotes, colons and indentation around there",
            )
            continue
        trees.append(meant)
    if not any(text.is_about_controllers for text in trees):
        return
    whole = Tree()
    for text in trees:
        whole.load(text.text, text.location)
    if ros2.is_ros2(whole.root):
        yield from whole.findings
        yield from ros2.controller_findings(whole.root, robot)
    else:
        yield from ros1.controller_findings(ControllerConfig(whole), robot)
