"""One launch file with all that it loads: robots, parameters and controllers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

from tool0.control.config import ControllerConfig
from tool0.description.finding import Finding, warning_at
from tool0.description.yaml_tree import Tree
from tool0.errors import ConfigError
from tool0.lint.control import request_findings, requests
from tool0.lint.launch.comments import commented_elements
from tool0.lint.launch.model import LaunchFile
from tool0.lint.launch.packages import Packages
from tool0.lint.launch.reader import read_launch
from tool0.lint.parameters.yaml_text import YamlText, yaml_findings
from tool0.lint.robot.facts import RobotFacts


@final
@dataclass(frozen=True, slots=True)
class Robot:
    """A robot that a launch file puts on the parameter server."""

    file: Path
    args: Mapping[str, str] | None
    """The arguments of xacro; None if it is URDF."""


@final
@dataclass(frozen=True, slots=True)
class ReadLaunch:
    """A launch file as far as it could be read."""

    findings: tuple[Finding, ...]
    robots: tuple[Robot, ...] = ()
    yamls: tuple[YamlText, ...] = ()
    included: tuple[Path, ...] = ()
    spawns: bool = False
    """Whether Gazebo gets the robot."""
    launch: LaunchFile | None = field(default=None, repr=False)


def read(file: Path, packages: Mapping[str, Path]) -> ReadLaunch:
    """Return what a launch file loads, and what is wrong with itself.

    Args:
        file: The launch file.
        packages: Name → folder of packages that come before all others.
    """
    launch = read_launch(file, {}, Packages(packages))
    yamls = []
    for rosparam in launch.rosparams():
        if rosparam.command == "load" and rosparam.yaml is not None:
            text = rosparam.yaml.resolved or rosparam.yaml.raw
            yamls.append(YamlText(text, rosparam.yaml.location))
    return ReadLaunch(
        findings=(*launch.findings, *_commented_out(launch, yamls)),
        robots=tuple(_robots(launch)),
        yamls=tuple(yamls),
        included=tuple(child.file for child in launch.files() if child.file != file),
        spawns=any(node.package.resolved == "gazebo_ros" for node in launch.nodes()),
        launch=launch,
    )


def control_findings(read: ReadLaunch, robot: RobotFacts | None) -> Iterator[Finding]:
    """Yield what is wrong between a launch file's controllers, YAML and robot."""
    yield from yaml_findings(read.yamls, robot)
    wanted = list(requests(read.launch)) if read.launch is not None else []
    if not wanted:
        return
    tree = Tree()
    for yaml in read.yamls:
        try:
            tree.load(yaml.text, yaml.location)
        except ConfigError:
            return  # what it defines is unknown, and it was told
    files = dict.fromkeys(str(yaml.location.file) for yaml in read.yamls)
    yield from request_findings(wanted, ControllerConfig(tree), list(files))


def _robots(launch: LaunchFile) -> Iterator[Robot]:
    for parameter in launch.parameters():
        words = parameter.words
        if parameter.source == "command" and words and _is_xacro(words[0]):
            pairs = [word.partition(":=") for word in words[1:] if ":=" in word]
            files = [w for w in words[1:] if ":=" not in w and not w.startswith("-")]
            if files:
                yield Robot(Path(files[-1]), {key: value for key, _, value in pairs})
        elif parameter.source == "textfile" and parameter.content.resolved:
            path = Path(parameter.content.resolved)
            if path.suffix == ".urdf":
                yield Robot(path, None)


def _is_xacro(program: str) -> bool:
    return Path(program).name in ("xacro", "xacro.py")


def _commented_out(launch: LaunchFile, yamls: list[YamlText]) -> Iterator[Finding]:
    """Yield YAML whose only <rosparam> is commented out."""
    loaded = {yaml.location.file.name for yaml in yamls if yaml.location.file}
    for child in launch.files():
        for location, element in commented_elements(child.file):
            if element.tagName != "rosparam":
                continue
            file = element.getAttribute("file")
            if file and Path(file).name not in loaded:
                yield warning_at(
                    location,
                    "commented-out",
                    "rosparam",
                    f"is commented out, and nothing else loads '{file}': what "
                    "stands in it has no effect",
                    "load it, or delete the line and the file",
                )
