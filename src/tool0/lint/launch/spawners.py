"""Finds the controllers that the nodes of a launch file request from a manager."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

from tool0.control.config import ControllerConfig
from tool0.control.parameters import joint_entries
from tool0.control.ros1.dialect import ROS1
from tool0.description.finding import Finding, error_at
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import SourceLocation, nearest_name
from tool0.lint.launch.model import LaunchFile, Node

_SPAWNERS: Final = ("spawner", "spawner.py")
_TAKES_VALUE: Final = frozenset(
    {
        *("--namespace", "--timeout", "-t", "--shutdown-timeout"),
        *("-c", "--controller-manager", "-p", "--param-file", "-n"),
        *("--controller-type", "--controller-manager-timeout", "--switch-timeout"),
        *("--service-call-timeout", "--controller-ros-args", "-f"),
        "--fallback_controllers",
    }
)
"""Options of the ROS 1 or ROS 2 spawner that take a value."""
_PARAM_FILE: Final = ("-p", "--param-file")
_NOT_STARTED: Final = frozenset({"--stopped", "--inactive", "--load-only"})


@final
@dataclass(frozen=True, slots=True)
class SpawnRequest:
    """A controller that a node requests from the controller manager."""

    name: str
    is_started: bool
    location: SourceLocation


def spawn_requests(launch: LaunchFile) -> Iterator[SpawnRequest]:
    """Yield the controllers that the nodes of a launch file load or start."""
    for node in launch.nodes():
        words = list(node.words)
        command = "spawn" if _NOT_STARTED.isdisjoint(words) else "load"
        if node.package.resolved != "controller_manager":
            continue
        if node.type.resolved == "controller_manager" and words:
            command = words.pop(0)
        elif node.type.resolved not in _SPAWNERS:
            continue
        if command not in ("spawn", "start", "load"):
            continue
        location = node.place.location if node.args is None else node.args.location
        for name in _names(words):
            is_started = command != "load" and node.place.holds is not None
            yield SpawnRequest(name, is_started, location)


def _names(words: Sequence[str]) -> Iterator[str]:
    skip = False
    for word in words:
        if word and not skip and not word.startswith("-") and ":=" not in word:
            yield word
        skip = word in _TAKES_VALUE


def parameter_files(node: Node) -> Iterator[str]:
    """Yield the parameter files that a ROS 2 spawner passes to its controllers."""
    if node.type.resolved in _SPAWNERS:
        for option, value in zip(node.words, node.words[1:], strict=False):
            if option in _PARAM_FILE and value:
                yield value


def spawn_findings(
    wanted: Sequence[SpawnRequest], config: ControllerConfig, files: Sequence[str]
) -> Iterator[Finding]:
    """Yield findings about undefined controllers and about conflicting controllers."""
    known = config.names
    for request in wanted:
        if request.name in known or _has_type(request.name, config):
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


def _has_type(name: str, config: ControllerConfig) -> bool:
    """Return whether a controller's own parameters contain its type.

    The spawner sets the type in these parameters.
    """
    end = f"/{name}/ros__parameters/type"
    return any(f"/{leaf.key}".endswith(end) for leaf in config.tree.root.leaves())


def _conflicts(
    started: Sequence[SpawnRequest], config: ControllerConfig
) -> Iterator[Finding]:
    claims: dict[str, SpawnRequest] = {}
    reported: set[tuple[str, str]] = set()
    for request in started:
        for claim in _claims(request.name, config):
            other = claims.setdefault(claim, request)
            pair = (other.name, request.name)
            if other.name == request.name or pair in reported:
                continue
            reported.add(pair)
            yield error_at(
                request.location,
                "two-controllers",
                request.name,
                f"'{other.name}' and '{request.name}' are both started, and "
                f"both command '{claim}': the manager refuses the second",
                f"start one of them; load the other stopped ({other.location})",
            )


def _claims(name: str, config: ControllerConfig) -> Iterator[str]:
    """Yield the resources that a controller claims.

    The resources are joints in ROS 1, and interfaces in ROS 2.
    """
    entry = config.dialect.parameters(config.tree.root, name)
    kind = config.types.get(name, "")
    if entry is None or _only_reads(kind):
        return
    for joint in joint_entries(entry):
        if config.dialect is ROS1:
            yield str(joint.scalar)
            continue
        for interface in _interfaces(kind, entry):
            yield f"{joint.scalar}/{interface}"


def _only_reads(kind: str) -> bool:
    if kind in ROS1.types:
        return "publish_rate" in ROS1.parameters_of(kind)
    words = ("state", "sensor", "broadcaster")
    return any(word in kind.lower() for word in words)


def _interfaces(kind: str, entry: YamlEntry) -> Iterator[str]:
    """Yield the interfaces of each joint that a ROS 2 controller commands."""
    named, one = entry.find("command_interfaces"), entry.find("interface_name")
    if named is not None:
        yield from (str(item.scalar) for item in named.items)
    elif one is not None:
        yield str(one.scalar)
    else:
        package = kind.partition("/")[0]
        if package.endswith("_controllers"):  # for example, position_controllers
            yield package.removesuffix("_controllers")
