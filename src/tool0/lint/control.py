"""Who starts which controllers in a launch file, and whether they can be started."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

from tool0.control.config import ControllerConfig
from tool0.control.controller_types import TYPES, parameters_of
from tool0.description.finding import Finding, error_at
from tool0.errors import SourceLocation, nearest_name
from tool0.lint.launch.model import LaunchFile, Node

_SPAWNERS = ("spawner", "spawner.py")
_TAKES_VALUE = ("--namespace", "--timeout", "-t", "--shutdown-timeout")


@final
@dataclass(frozen=True, slots=True)
class Request:
    """A controller that a node asks the controller manager for."""

    name: str
    is_started: bool
    location: SourceLocation


def requests(launch: LaunchFile) -> Iterator[Request]:
    """Yield the controllers that the nodes of a launch file load or start."""
    for node in launch.nodes():
        if node.package.resolved == "controller_manager":
            yield from _requests_of(node)


def _requests_of(node: Node) -> Iterator[Request]:
    words = list(node.words)
    is_started = "--stopped" not in words
    if node.type.resolved not in _SPAWNERS:
        if node.type.resolved != "controller_manager" or not words:
            return
        command = words.pop(0)
        if command not in ("spawn", "start", "load"):
            return
        is_started = command != "load"
    location = node.place.location if node.args is None else node.args.location
    skip = False
    for word in words:
        if not skip and not word.startswith("-") and ":=" not in word:
            yield Request(word, is_started, location)
        skip = word in _TAKES_VALUE


def request_findings(
    wanted: Sequence[Request], config: ControllerConfig, files: Sequence[str]
) -> Iterator[Finding]:
    """Yield controllers that no YAML defines, and those that fight over a joint.

    Args:
        wanted: What the launch file asks for.
        config: All parameters that it loads.
        files: The YAML files that these came from, for messages.
    """
    known = config.names
    for request in wanted:
        if request.name in known:
            continue
        near = nearest_name(request.name, known)
        where = ", ".join(files) or "and no YAML is loaded"
        yield error_at(
            request.location,
            "no-controller",
            request.name,
            f"no YAML that is loaded defines the controller '{request.name}' "
            f"({where}), so it does not load",
            f"did you mean '{near}'?"
            if near
            else f"defined are: {', '.join(known) or 'none'}",
        )
    yield from _fights([item for item in wanted if item.is_started], config)


def _fights(started: Sequence[Request], config: ControllerConfig) -> Iterator[Finding]:
    claims: dict[str, Request] = {}
    told: set[tuple[str, str]] = set()
    for request in started:
        for joint in _claimed(request.name, config):
            other = claims.setdefault(joint, request)
            pair = (other.name, request.name)
            if other.name == request.name or pair in told:
                continue
            told.add(pair)
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
    entry = config.tree.root.children.get(name)
    if entry is None or _only_reads(config.types.get(name, "")):
        return
    if "joint" in entry.children:
        yield str(entry.children["joint"].scalar)
    if "joints" in entry.children:
        yield from (str(item.scalar) for item in entry.children["joints"].items)


def _only_reads(type_name: str) -> bool:
    """Return whether a controller only publishes."""
    if type_name in TYPES:
        return "publish_rate" in parameters_of(type_name)
    return "state" in type_name.lower() or "sensor" in type_name.lower()
