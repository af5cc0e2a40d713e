"""Checks a launch file, and the robots, parameters and controllers that it loads."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import final
from xml.parsers import expat

from tool0.control.config import ControllerConfig
from tool0.description.finding import Finding, warning_at
from tool0.description.yaml_tree import Tree
from tool0.errors import ConfigError, DescriptionError, SourceLocation
from tool0.lint.launch.load_context import is_file, read_limited
from tool0.lint.launch.model import LaunchFile, Node
from tool0.lint.launch.reader import read_launch
from tool0.lint.launch.simulated_time import missing_sim_time
from tool0.lint.launch.spawners import (
    parameter_files,
    spawn_findings,
    spawn_requests,
)
from tool0.lint.launch.xacro_files import xacro_call
from tool0.lint.packages import PackageIndex, Packages
from tool0.lint.parameters.yaml_text import (
    YamlText,
    syntax_findings,
    yaml_findings,
)
from tool0.lint.robot.facts import RobotFacts

_OF_ROS2 = re.compile(
    r"""<node\b[^>]*\bexec\s*=|<let\b|\$\((?:var|find-pkg-\w+)\s"""
    r"""|<arg\b[^>]*\bdescription\s*="""
)
_ROSPARAM = re.compile(r"""<rosparam\b[^<>]*\bfile=["']([^"'<>]+)["'][^<>]*>""")


@final
@dataclass(frozen=True, slots=True)
class ParsedLaunch:
    """The readable parts of a launch file."""

    findings: tuple[Finding, ...]
    robots: tuple[tuple[Path, Mapping[str, str] | None], ...] = ()
    """Robot files, each with its xacro arguments, or with None for a URDF file."""
    yamls: tuple[YamlText, ...] = ()
    included: tuple[Path, ...] = ()
    spawns: bool = False
    """Whether the robot is spawned in Gazebo."""
    launch: LaunchFile | None = field(default=None, repr=False)
    has_unread_yaml: bool = False
    """Whether the file loads YAML that could not be read, for example YAML of another
    package."""
    notes: tuple[str, ...] = ()
    """Parts of the file that could not be analyzed."""


def read_launch_file(file: Path, packages: Packages) -> ParsedLaunch:
    """Return the robots and parameters that a launch file loads, and the findings."""
    if is_xml_of_ros2(file):
        note = f"{file}: launch files of ROS 2 in XML are not read"
        return ParsedLaunch(findings=(), notes=(note,))
    launch = read_launch(file, {}, PackageIndex(packages))
    yamls: list[YamlText] = []
    values: list[YamlText] = []  # YAML of single parameters, which need not be mappings
    for rosparam in launch.rosparams():
        if rosparam.command == "load" and rosparam.yaml is not None:
            text = rosparam.yaml.resolved or rosparam.yaml.raw
            is_value = any(name == "param" for name, _ in rosparam.names)
            (values if is_value else yamls).append(
                YamlText(text, rosparam.yaml.location)
            )
    for node in launch.nodes():
        for name in parameter_files(node):
            path = Path(name).resolve()
            if not any(yaml.location.file == path for yaml in yamls):
                yamls.append(_parameter_file(node, path))
    of_values = [finding for value in values for finding in syntax_findings(value)]
    return ParsedLaunch(
        findings=(
            *launch.findings,
            *of_values,
            *(() if launch.is_python else _commented_out(launch, yamls)),
            *missing_sim_time(launch),
        ),
        robots=tuple(_robots(launch)),
        yamls=tuple(yamls),
        included=tuple(f.file for f in launch.files() if f.file != launch.file),
        spawns=any(node.package.resolved == "gazebo_ros" for node in launch.nodes()),
        launch=launch,
        has_unread_yaml=any(
            rosparam.command == "load" and rosparam.yaml is None
            for rosparam in launch.rosparams()
        ),
        notes=(*launch.notes, *(() if launch.is_python else _required(launch))),
    )


def _required(launch: LaunchFile) -> Iterator[str]:
    """Yield notes on the arguments that a launch file requires."""
    for argument in launch.arguments:
        if argument.origin == "missing":
            yield (
                f"{argument.place.location}: the argument '{argument.name}' has no "
                "default: what depends on it was not checked"
            )


def control_findings(
    read: ParsedLaunch, robot: RobotFacts | None, packages: Packages
) -> Iterator[Finding]:
    """Yield mismatches between the controllers, YAML and robot of a launch file."""
    yamls = [*read.yamls, *_plugin_files(read, robot)]
    wanted = list(spawn_requests(read.launch)) if read.launch is not None else []
    started = {request.name for request in wanted if request.is_started}
    yield from yaml_findings(yamls, robot, packages, started)
    if not wanted:
        return
    tree = Tree()
    for yaml in yamls:
        try:
            tree.load(yaml.text, yaml.location)
        except ConfigError:
            return  # the content of the YAML is unknown, which has been reported
    config = ControllerConfig(tree)
    files = dict.fromkeys(str(yaml.location.file) for yaml in yamls)
    if (
        config.names and not read.has_unread_yaml
    ):  # otherwise, another launch file contains the manager
        yield from spawn_findings(wanted, config, list(files))


def is_xml_of_ros2(file: Path) -> bool:
    """Return whether an XML launch file is for ROS 2.

    The file is for ROS 2 if it contains words that ROS 1 does not use.
    """
    if file.suffix == ".py":
        return False
    with suppress(DescriptionError):
        text = read_limited(file).decode("utf-8", errors="replace")
        return _OF_ROS2.search(text) is not None
    return False


def _parameter_file(node: Node, file: Path) -> YamlText:
    """Return the YAML that a spawner passes to its controllers.

    The text is empty if the file cannot be read.
    """
    with suppress(DescriptionError, UnicodeDecodeError):
        text = read_limited(file).decode("utf-8")
        return YamlText(text, SourceLocation(file, 1))
    return YamlText("", node.place.location)


def _plugin_files(read: ParsedLaunch, robot: RobotFacts | None) -> Iterator[YamlText]:
    """Yield the YAML files that the robot's ros2_control plugins load."""
    loaded = {yaml.location.file for yaml in read.yamls}
    for plugin in () if robot is None else robot.plugins:
        for at, name in plugin.parameters if plugin.is_control_of_ros2 else ():
            path = Path(name)
            if at.key == "parameters" and path.is_absolute() and path not in loaded:
                with suppress(DescriptionError, UnicodeDecodeError):
                    text = read_limited(path).decode("utf-8")
                    yield YamlText(text, SourceLocation(path, 1))


def _robots(launch: LaunchFile) -> Iterator[tuple[Path, Mapping[str, str] | None]]:
    for parameter in launch.parameters():
        call = xacro_call(parameter)
        if call is not None and call.file is not None:
            if is_file(call.file):  # otherwise, the call has a finding
                yield call.file, call.args
        elif parameter.source == "textfile" and parameter.content.resolved:
            path = Path(parameter.content.resolved)
            if path.suffix == ".urdf":
                yield path, None


def _commented_out(launch: LaunchFile, yamls: list[YamlText]) -> Iterator[Finding]:
    """Yield a finding for each YAML file whose only <rosparam> is commented out."""
    loaded = {yaml.location.file.name for yaml in yamls if yaml.location.file}
    commented = (
        item for child in launch.files() for item in commented_rosparams(child.file)
    )
    for location, file in commented:
        if Path(file).name not in loaded:
            yield warning_at(
                location,
                "commented-out",
                "rosparam",
                f"is commented out, and nothing else loads '{file}': its "
                "contents have no effect",
                "load it, or delete the line and the file",
            )


def commented_rosparams(launch_file: Path) -> Iterator[tuple[SourceLocation, str]]:
    """Yield the location and file of each ``<rosparam file="…">`` in XML comments."""
    comments: list[tuple[int, str]] = []
    parser = expat.ParserCreate()
    parser.CommentHandler = lambda data: comments.append(
        (parser.CurrentLineNumber, data)
    )
    with suppress(DescriptionError, expat.ExpatError, LookupError, ValueError):
        # the file is parsed up to its first syntax error
        parser.Parse(read_limited(launch_file), True)
    for first_line, comment in comments:
        for match in _ROSPARAM.finditer(comment):
            line = first_line + comment.count("\n", 0, match.start())
            yield SourceLocation(launch_file, line), match[1]
