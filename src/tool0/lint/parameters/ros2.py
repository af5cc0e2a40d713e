"""Rules for ros2_control's YAML (ROS 2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import final

from tool0.control.config import TYPES as TYPES_OF_ROS1
from tool0.control.config import siblings
from tool0.description.finding import Finding, Severity, error_at
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import is_typo, nearest_name
from tool0.lint.parameters.ros1 import unknown_joints
from tool0.lint.parameters.ros2_tables import (
    COMMON,
    MANAGER,
    OTHER_TYPES,
    TYPES,
    required_parameters,
)
from tool0.lint.plugins import PluginIndex
from tool0.lint.robot.facts import RobotFacts

PARAMETERS = "ros__parameters"
_MANAGER = "controller_manager"
_TYPO = 0.75
_MISSPELT = ("ros_parameters", "ros__parameter", "ros_parameter", "ros___parameters")


def is_ros2(root: YamlEntry) -> bool:
    """Return whether a file has the layout of ROS 2, perhaps with a typo."""
    parts = {part for leaf in root.leaves() for part in leaf.key.split("/")}
    return not parts.isdisjoint((PARAMETERS, *_MISSPELT)) or _MANAGER in root.children


def controller_findings(
    root: YamlEntry, robot: RobotFacts | None, plugins: PluginIndex
) -> Iterator[Finding]:
    """Yield the faults of the controllers of a YAML, for ``robot`` if known."""
    nodes: dict[str, YamlEntry] = {}
    yield from _collect(root, nodes)
    manager = nodes.pop(_MANAGER, None)
    declared: dict[str, YamlEntry] = {}
    for name, entry in ({} if manager is None else manager.children).items():
        if "type" in entry.children:
            declared[name] = entry.children["type"]
        elif name not in MANAGER and not entry.is_mapping:
            near = nearest_name(name, MANAGER, _TYPO)
            if near is not None:
                yield _unread(entry, "the controller manager", near)
    for name, entry in nodes.items():
        own = entry.children.get("type")
        if own is not None:
            declared.setdefault(name, own)
    yield from _misnamed(nodes, declared)
    for name, type_entry in declared.items():
        parameters = nodes.get(name)
        yield from _Ros2Controller(
            name, type_entry, parameters, robot, plugins
        ).findings()


def _collect(root: YamlEntry, nodes: dict[str, YamlEntry]) -> Iterator[Finding]:
    """Put the parameters of every node into ``nodes``, by the node's name."""
    for name, entry in root.children.items():
        children = entry.children
        inner = children.get(PARAMETERS)
        if inner is not None:
            inner.location = entry.location  # a person looks for the node's name
            nodes[name] = inner
            continue
        wrong = next((key for key in _MISSPELT if key in children), None)
        if wrong is not None:
            yield _missing_level(children[wrong], f"'{wrong}' should be '{PARAMETERS}'")
            nodes[name] = children[wrong]
        elif name == _MANAGER or {"joints", "command_interfaces"} & children.keys():
            yield _missing_level(
                entry, f"'{PARAMETERS}:' must stand between '{name}' and its parameters"
            )
            nodes[name] = entry
        else:
            yield from _collect(entry, nodes)


def _missing_level(entry: YamlEntry, remedy: str) -> Finding:
    message = "no node of ROS 2 gets these parameters"
    return entry.finding("no-ros-parameters", message, remedy)


def _misnamed(
    nodes: Mapping[str, YamlEntry], declared: Mapping[str, YamlEntry]
) -> Iterator[Finding]:
    """Yield parameters whose controller is declared under a similar name."""
    without = [name for name in declared if name not in nodes]
    for name, entry in nodes.items():
        near = nearest_name(name, without, _TYPO)
        if name not in declared and near is not None:
            yield error_at(
                entry.location,
                "no-controller",
                name,
                "the controller manager declares no such controller, so these "
                "parameters are unused",
                f"did you mean '{near}'?",
            )


def _unread(entry: YamlEntry, who: str, near: str) -> Finding:
    message = f"{who} does not read it"
    written = entry.key.rpartition("/")[2].rpartition(".")[2]
    severity: Severity = "error" if is_typo(written, near) else "warning"
    return entry.finding("unread-key", message, f"did you mean '{near}'?", severity)


@final
@dataclass(frozen=True, slots=True)
class _Ros2Controller:
    """One controller for the manager to load."""

    name: str
    type_entry: YamlEntry
    parameters: YamlEntry | None
    robot: RobotFacts | None
    plugins: PluginIndex

    @property
    def type(self) -> str:
        return str(self.type_entry.scalar)

    @property
    def keys(self) -> Mapping[str, YamlEntry]:
        return {} if self.parameters is None else self.parameters.children

    def findings(self) -> Iterator[Finding]:
        patterns = TYPES.get(self.type)
        if patterns is None:
            yield from self._unknown_type()
            return
        yield from self._missing()
        joints = [
            (str(entry.scalar), entry)
            for key in ("joint", "joints")
            if key in self.keys
            for entry in (self.keys[key].items or [self.keys[key]])
        ]
        if self.robot is not None or len(joints) > 1:
            yield from unknown_joints(joints, self.robot)
        yield from self._interfaces(joints)
        yield from self._unread_keys(patterns, {n for n, _ in joints})

    def _unknown_type(self) -> Iterator[Finding]:
        if self.type in OTHER_TYPES or self.type in self.plugins:
            return
        near = nearest_name(self.type, (*TYPES, *OTHER_TYPES))
        severity: Severity = "error"
        if self.type in TYPES_OF_ROS1 and self.type not in TYPES:
            kind = self.type.partition("/")[2]
            same = [name for name in TYPES if name.endswith(f"/{kind}")]
            remedy = f"write '{same[0]}'" if same else "write joint_state_broadcaster/…"
            message = f"'{self.type}' is a controller of ROS 1, in a file for ROS 2"
        elif is_typo(self.type, near):
            message = f"there is no controller type '{self.type}'"
            remedy = f"did you mean '{near}'?"
        else:
            severity = "warning"
            message = f"no package here exports the controller type '{self.type}'"
            remedy = "put its package into the workspace"
        yield self.type_entry.finding("unknown-type", message, remedy, severity)

    def _missing(self) -> Iterator[Finding]:
        missing = [
            key for key in required_parameters(self.type) if key not in self.keys
        ]
        if not missing:
            return
        where = self.parameters or self.type_entry
        yield where.finding(
            "missing-key",
            f"{self.type} does not configure without {' and '.join(missing)}",
            f"write them under '{self.name}: {PARAMETERS}:'",
        )

    def _interfaces(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        entry = self.keys.get("command_interfaces")
        wanted = [str(item.scalar) for item in (entry.items if entry else ())]
        if "effort" in wanted and "position" not in wanted and "gains" not in self.keys:
            yield (entry or self.type_entry).finding(
                "missing-gains",
                "commands effort, so it closes the loop itself and needs gains",
                f"write gains: {{<joint>: {{p: …}}}} under {self.name}",
            )
        if self.robot is None or not self.robot.ros2_joints:
            return
        for name, place in joints:
            offered = self.robot.ros2_joints.get(name)
            lacking = [kind for kind in wanted if kind not in (offered or ())]
            if offered is None and name in self.robot.joints:
                yield place.finding(
                    "no-transmission",
                    f"'{name}' is not in the robot's <ros2_control>",
                    "add it there, with its command interfaces",
                )
            elif offered is not None and lacking:
                yield place.finding(
                    "interface-mismatch",
                    f"commands {', '.join(lacking)}, but <ros2_control> offers "
                    f"{', '.join(offered) or 'nothing'} for '{name}'",
                    "change command_interfaces, or the robot's <ros2_control>",
                )

    def _unread_keys(
        self, patterns: frozenset[str], joints: set[str]
    ) -> Iterator[Finding]:
        read = patterns | COMMON
        reported: set[str] = set()
        for leaf in self.parameters.leaves() if self.parameters else ():
            base = self.parameters.key if self.parameters else ""
            path = leaf.key[len(base) + 1 :].split("/")
            pattern = "/".join("*" if part in joints else part for part in path)
            dotted = pattern.replace(".", "/")  # ROS 2 reads a dot as a level
            if any(_covers(known, p) for known in read for p in (pattern, dotted)):
                continue
            if path[0] in reported and len(path) > 1 and path[1] not in joints:
                continue
            reported.add(path[0])
            yield self._unread(leaf, path, pattern, read)

    def _unread(
        self, leaf: YamlEntry, path: list[str], pattern: str, read: frozenset[str]
    ) -> Finding:
        others = [name for name, keys in TYPES.items() if pattern in keys]
        near = nearest_name(path[-1], siblings(pattern, read), _TYPO)
        severity: Severity = "error"
        kind = self.type.partition("/")[2]
        if near is not None:
            return _unread(leaf, kind, near)
        if others:
            kinds = " and ".join(sorted({name.partition("/")[2] for name in others}))
            rule, message = "misplaced-key", f"{kind} does not read it; {kinds} does"
        else:
            rule, severity = "unread-key", "warning"
            message = f"no version of {kind} that is known here reads it"
        return leaf.finding(rule, message, "remove it", severity=severity)


def _covers(candidate: str, pattern: str) -> bool:
    """Return whether ``pattern`` matches a known parameter or its namespace.

    A ``*`` that is read stands for any name: a joint that the list lacks is a joint
    all the same.
    """
    read, asked = candidate.split("/"), pattern.split("/")
    if len(read) > len(asked):
        return False
    return all(
        a == b or (a == "*" and b not in ("goal_time", "stopped_velocity_tolerance"))
        for a, b in zip(read, asked, strict=False)
    )
