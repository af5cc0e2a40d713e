"""One launch file with everything it loads: robots, parameters and controllers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import final
from xml.parsers import expat

from tool0.control.config import TYPES, ControllerConfig, parameters_of
from tool0.control.parameters import joint_entries
from tool0.description.finding import Finding, error_at, warning_at
from tool0.description.yaml_tree import Tree
from tool0.errors import ConfigError, DescriptionError, SourceLocation, nearest_name
from tool0.lint.launch.load_context import read_limited
from tool0.lint.launch.model import LaunchFile
from tool0.lint.launch.reader import read_launch
from tool0.lint.launch.xacro_files import xacro_call
from tool0.lint.packages import PackageIndex, Packages
from tool0.lint.parameters.yaml_text import (
    YamlText,
    syntax_findings,
    yaml_findings,
)
from tool0.lint.robot.facts import RobotFacts

_ROSPARAM = re.compile(r"""<rosparam\b[^<>]*\bfile=["']([^"'<>]+)["'][^<>]*>""")
_SPAWNERS = ("spawner", "spawner.py")
_TAKES_VALUE = ("--namespace", "--timeout", "-t", "--shutdown-timeout")


@final
@dataclass(frozen=True, slots=True)
class ParsedLaunch:
    """The readable part of a launch file."""

    findings: tuple[Finding, ...]
    robots: tuple[tuple[Path, Mapping[str, str] | None], ...] = ()
    """Each file, and the arguments of xacro: None if it is URDF."""
    yamls: tuple[YamlText, ...] = ()
    included: tuple[Path, ...] = ()
    spawns: bool = False
    """Whether the robot is spawned in Gazebo."""
    launch: LaunchFile | None = field(default=None, repr=False)


def read_launch_file(file: Path, packages: Packages) -> ParsedLaunch:
    """Return what a launch file loads, and its own faults."""
    launch = read_launch(file, {}, PackageIndex(packages))
    yamls: list[YamlText] = []
    values: list[YamlText] = []  # of single parameters: need not be mappings
    for rosparam in launch.rosparams():
        if rosparam.command == "load" and rosparam.yaml is not None:
            text = rosparam.yaml.resolved or rosparam.yaml.raw
            is_value = any(name == "param" for name, _ in rosparam.names)
            (values if is_value else yamls).append(
                YamlText(text, rosparam.yaml.location)
            )
    of_values = [finding for value in values for finding in syntax_findings(value)]
    return ParsedLaunch(
        findings=(*launch.findings, *of_values, *_commented_out(launch, yamls)),
        robots=tuple(_robots(launch)),
        yamls=tuple(yamls),
        included=tuple(child.file for child in launch.files() if child.file != file),
        spawns=any(node.package.resolved == "gazebo_ros" for node in launch.nodes()),
        launch=launch,
    )


def control_findings(
    read: ParsedLaunch, robot: RobotFacts | None, packages: Packages
) -> Iterator[Finding]:
    """Yield mismatches between a launch file's controllers, YAML and robot."""
    yield from yaml_findings(read.yamls, robot, packages)
    wanted = list(_spawn_requests(read.launch)) if read.launch is not None else []
    if not wanted:
        return
    tree = Tree()
    for yaml in read.yamls:
        try:
            tree.load(yaml.text, yaml.location)
        except ConfigError:
            return  # its content is unknown, which was reported
    files = dict.fromkeys(str(yaml.location.file) for yaml in read.yamls)
    yield from _spawn_findings(wanted, ControllerConfig(tree), list(files))


def _robots(launch: LaunchFile) -> Iterator[tuple[Path, Mapping[str, str] | None]]:
    for parameter in launch.parameters():
        call = xacro_call(parameter)
        if call is not None and call.file is not None:
            yield call.file, call.args
        elif parameter.source == "textfile" and parameter.content.resolved:
            path = Path(parameter.content.resolved)
            if path.suffix == ".urdf":
                yield path, None


def _commented_out(launch: LaunchFile, yamls: list[YamlText]) -> Iterator[Finding]:
    """Yield YAML whose only <rosparam> is commented out."""
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
                f"is commented out, and nothing else loads '{file}': what "
                "stands in it has no effect",
                "load it, or delete the line and the file",
            )


def commented_rosparams(launch_file: Path) -> Iterator[tuple[SourceLocation, str]]:
    """Yield each ``<rosparam file="…">`` in an XML file's comments: place and file."""
    comments: list[tuple[int, str]] = []
    parser = expat.ParserCreate()
    parser.CommentHandler = lambda data: comments.append(
        (parser.CurrentLineNumber, data)
    )
    with suppress(DescriptionError, expat.ExpatError, LookupError, ValueError):
        parser.Parse(read_limited(launch_file), True)  # up to the first mistake
    for first_line, comment in comments:
        for match in _ROSPARAM.finditer(comment):
            line = first_line + comment.count("\n", 0, match.start())
            yield SourceLocation(launch_file, line), match[1]


@final
@dataclass(frozen=True, slots=True)
class SpawnRequest:
    """A controller that a node requests from the controller manager."""

    name: str
    is_started: bool
    location: SourceLocation


def _spawn_requests(launch: LaunchFile) -> Iterator[SpawnRequest]:
    """Yield the controllers that the nodes of a launch file load or start."""
    for node in launch.nodes():
        words = list(node.words)
        command = "load" if "--stopped" in words else "spawn"
        if node.package.resolved != "controller_manager":
            continue
        if node.type.resolved == "controller_manager" and words:
            command = words.pop(0)
        elif node.type.resolved not in _SPAWNERS:
            continue
        if command not in ("spawn", "start", "load"):
            continue
        location = node.place.location if node.args is None else node.args.location
        skip = False
        for word in words:
            if not skip and not word.startswith("-") and ":=" not in word:
                yield SpawnRequest(word, command != "load", location)
            skip = word in _TAKES_VALUE


def _spawn_findings(
    wanted: Sequence[SpawnRequest], config: ControllerConfig, files: Sequence[str]
) -> Iterator[Finding]:
    """Yield controllers that none of ``files`` defines, and two that claim a joint."""
    known = config.names
    for request in wanted:
        if request.name in known:
            continue
        near = nearest_name(request.name, known)
        where = ", ".join(files) or "and no YAML is loaded"
        defined = ", ".join(known) or "none"
        yield error_at(
            request.location,
            "no-controller",
            request.name,
            f"no YAML that is loaded defines the controller '{request.name}' "
            f"({where}), so it does not load",
            f"did you mean '{near}'?" if near else f"defined are: {defined}",
        )
    yield from _conflicts([item for item in wanted if item.is_started], config)


def _conflicts(
    started: Sequence[SpawnRequest], config: ControllerConfig
) -> Iterator[Finding]:
    claims: dict[str, SpawnRequest] = {}
    reported: set[tuple[str, str]] = set()
    for request in started:
        for joint in _claimed(request.name, config):
            other = claims.setdefault(joint, request)
            pair = (other.name, request.name)
            if other.name == request.name or pair in reported:
                continue
            reported.add(pair)
            yield error_at(
                request.location,
                "two-controllers",
                request.name,
                f"'{other.name}' and '{request.name}' are both started, and "
                f"both command '{joint}': the manager refuses the second",
                f"start one of them; load the other stopped ({other.location})",
            )


def _claimed(name: str, config: ControllerConfig) -> Iterator[str]:
    """Yield the joints that a controller commands."""
    entry, kind = config.tree.root.children.get(name), config.types.get(name, "")
    if kind in TYPES:
        only_reads = "publish_rate" in parameters_of(kind)
    else:
        only_reads = "state" in kind.lower() or "sensor" in kind.lower()
    if entry is not None and not only_reads:
        yield from (str(item.scalar) for item in joint_entries(entry))
