"""Parameters that do nothing: ROS ignores them without a word."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import final

from tool0.control.config import ControllerConfig
from tool0.control.parameter_tables import (
    GAINS,
    LIMITS,
    parameters_of,
    readers_of,
)
from tool0.description.finding import Finding, Severity
from tool0.description.model import RobotModel
from tool0.description.yaml_tree import Entry

OF_TOOL0 = ("gazebo-only", "not-enforced")
"""Rules that tell what tool0 does otherwise than Gazebo: no fault of the file."""
_GAZEBO_GAINS = "gazebo_ros_control/pid_gains"
_NOT_ENFORCED = ("max_acceleration", "max_jerk")
_JOINT_MAPPINGS = ("gains", "constraints", "velocity_ff")


def lint(
    config: ControllerConfig, model: RobotModel | None = None
) -> tuple[Finding, ...]:
    """Return what nothing reads, or does nothing, or is suspicious.

    Args:
        config: A person's parameters.
        model: The robot, to find names of joints that it lacks.
    """
    joints = None if model is None else [j.name for j in model.movable_joints]
    return lint_joints(config, joints)


def lint_joints(
    config: ControllerConfig, joints: Collection[str] | None
) -> tuple[Finding, ...]:
    """Do as ``lint``, given the names of the robot's movable joints, if known."""
    findings = list(config.tree.findings)
    for name, entry in (config.tree.root.children or {}).items():
        if name in config.names:
            findings += _lint_controller(entry, joints)
        else:
            findings += _lint_other(name, entry, joints)
    return tuple(sorted(findings, key=_place))


def _place(finding: Finding) -> tuple[str, int]:
    return str(finding.location.file), finding.location.line or 0


def _at(
    entry: Entry,
    rule: str,
    message: str,
    remedy: str,
    severity: Severity = "error",
) -> Finding:
    return Finding(
        location=entry.location,
        rule=rule,
        severity=severity,
        key=entry.key,
        message=message,
        remedy=remedy,
    )


@final
@dataclass(frozen=True, slots=True)
class _Reader:
    """What a controller reads."""

    type_name: str
    patterns: frozenset[str]
    joints: tuple[str, ...]

    @property
    def kind(self) -> str:
        return self.type_name.partition("/")[2]

    def reads(self, path: str) -> bool:
        return path in self.patterns or self.pattern(path) in self.patterns

    def pattern(self, path: str) -> str:
        return "/".join(
            "*" if part in self.joints else part for part in path.split("/")
        )

    def is_by_joint(self, name: str) -> bool:
        return any(pattern.startswith(f"{name}/*") for pattern in self.patterns)


def _lint_controller(entry: Entry, known: Collection[str] | None) -> Iterator[Finding]:
    type_name = str((entry.children or {})["type"].scalar)
    try:
        patterns = parameters_of(type_name)
    except KeyError:
        return  # loading it says so
    reader = _Reader(type_name, patterns, _joints_of(entry))
    reported: list[str] = []
    for leaf in entry.leaves():
        path = leaf.key[len(entry.key) + 1 :]
        if path == "type" or reader.reads(path):
            continue
        where = _outermost_unread(entry, path, reader)
        if where.key in reported:
            continue
        reported.append(where.key)
        yield _unread(where, where.key[len(entry.key) + 1 :], reader, known)
    yield from _idle_integrals(entry, patterns)


def _joints_of(entry: Entry) -> tuple[str, ...]:
    """Return the joints that a controller names."""
    children = entry.children or {}
    names: list[str] = []
    if "joint" in children:
        names.append(str(children["joint"].scalar))
    if "joints" in children:
        names += [str(item.scalar) for item in children["joints"].items or ()]
    return tuple(names)


def _outermost_unread(entry: Entry, path: str, reader: _Reader) -> Entry:
    """Return the namespace nearest to the controller of which nothing is read."""
    here = entry
    for part in path.split("/"):
        here = (here.children or {})[part]
        inner = here.key[len(entry.key) + 1 :]
        pattern = reader.pattern(inner)
        if not any(
            candidate == pattern or candidate.startswith(f"{pattern}/")
            for candidate in reader.patterns
        ):
            break
    return here


def _unread(
    entry: Entry, path: str, reader: _Reader, known: Collection[str] | None
) -> Finding:
    first, _, rest = path.partition("/")
    is_by_joint = first in _JOINT_MAPPINGS and reader.is_by_joint(first)
    if is_by_joint and rest and "/" not in rest:
        near = None
        if first == "constraints" and rest not in (known or ()):
            near = _nearest(rest, ("goal_time", "stopped_velocity_tolerance"))
        if near is None:
            return _not_a_joint(entry, rest, reader.joints, known)
        return _at(entry, "unread-key", "nothing reads it", f"did you mean '{near}'?")
    pattern = reader.pattern(path)
    others = [kind for kind in readers_of(pattern) if kind != reader.kind]
    if others:
        return _at(
            entry,
            "misplaced-key",
            f"{reader.kind} does not read it; read by {' and '.join(others)} only",
            "remove it, or take that controller",
        )
    if first in ("gains", "velocity_ff", "pid") and "/" not in path:
        return _at(
            entry,
            "misplaced-key",
            f"{reader.type_name} has no use for {first}: its interface needs no PID",
            "remove it",
        )
    near = _nearest(path.rpartition("/")[2], _siblings(pattern, reader.patterns))
    return _at(entry, "unread-key", f"{reader.kind} does not read it", _or_remove(near))


def _siblings(pattern: str, patterns: frozenset[str]) -> list[str]:
    """Return the keys that are read in the namespace of ``pattern``."""
    outer = pattern.rpartition("/")[0]
    prefix = f"{outer}/" if outer else ""
    return sorted(
        {
            candidate[len(prefix) :].partition("/")[0]
            for candidate in patterns
            if candidate.startswith(prefix)
        }
    )


def _not_a_joint(
    entry: Entry, name: str, joints: Sequence[str], known: Collection[str] | None
) -> Finding:
    near = _or_remove(_nearest(name, joints))
    if known is not None and name not in known:
        return _at(entry, "unknown-joint", f"the robot has no joint '{name}'", near)
    message = f"'{name}' is not among the controller's joints"
    return _at(entry, "unread-key", message, near)


def _nearest(name: str, valid: Collection[str]) -> str | None:
    close = difflib.get_close_matches(name, sorted(valid), n=1, cutoff=0.6)
    return close[0] if close else None


def _or_remove(near: str | None) -> str:
    return f"did you mean '{near}'?" if near else "remove it"


def _idle_integrals(entry: Entry, patterns: frozenset[str]) -> Iterator[Finding]:
    """Warn of integral gains whose contribution is clamped to zero."""
    if not any(pattern.endswith("/p") for pattern in patterns):
        return
    for gains in _mappings(entry):
        keys = gains.children or {}
        if "p" not in keys or not _number(keys.get("i")):
            continue
        clamps = [keys.get(k) for k in ("i_clamp", "i_clamp_min", "i_clamp_max")]
        if not any(map(_number, clamps)):
            yield _at(
                keys["i"],
                "idle-integral",
                "the integral contributes nothing, since i_clamp is "
                + ("0" if "i_clamp" in keys else "not given and hence 0"),
                "give i_clamp the largest effort that it may add, or leave i out",
                "warning",
            )


def _mappings(entry: Entry) -> Iterator[Entry]:
    for child in (entry.children or {}).values():
        if child.children is not None:
            yield child
            yield from _mappings(child)


def _number(entry: Entry | None) -> float:
    value = None if entry is None else entry.scalar
    return float(value) if isinstance(value, int | float) else 0.0


def _lint_other(
    name: str, entry: Entry, known: Collection[str] | None
) -> Iterator[Finding]:
    """Complain of what stands at the top and is no controller."""
    children = entry.children or {}
    gains = children.get("pid_gains")
    if gains is not None:
        yield _gazebo_gains(name, gains)
        yield from _unknown_joints(gains, known)
    elif name == "joint_limits":
        yield from _lint_limits(entry, known)
    elif name in GAINS | set(_JOINT_MAPPINGS) | {"joints", "joint", "type"}:
        yield _at(
            entry,
            "flat-yaml",
            "nothing reads it here; it belongs into a controller",
            "indent it",
        )
    elif name != "gazebo_ros_control":
        near = _nearest("type", list(children))
        yield _at(
            entry,
            "no-type",
            "nothing reads it: without a 'type' it is no controller",
            f"is '{near}' meant to be 'type'?" if near else "give it a type, or remove",
        )


def _gazebo_gains(name: str, gains: Entry) -> Finding:
    if name == "gazebo_ros_control":
        return _at(
            gains,
            "gazebo-only",
            "read by Gazebo's gazebo_ros_control only; the servos of position and "
            "velocity joints need no gains here",
            "",
            "warning",
        )
    return _at(
        gains,
        "misplaced-key",
        "nothing reads it",
        f"gazebo_ros_control reads '{_GAZEBO_GAINS}', for position and velocity joints "
        "only",
    )


def _unknown_joints(names: Entry, known: Collection[str] | None) -> Iterator[Finding]:
    for name, entry in (names.children or {}).items():
        if known is not None and name not in known:
            unused = [joint for joint in known if joint not in (names.children or {})]
            yield _at(
                entry,
                "unknown-joint",
                f"the robot has no joint '{name}'",
                _or_remove(_nearest(name, unused) or _nearest(name, known)),
            )


def _lint_limits(limits: Entry, known: Collection[str] | None) -> Iterator[Finding]:
    yield from _unknown_joints(limits, known)
    for joint in (limits.children or {}).values():
        keys = joint.children or {}
        for name, entry in keys.items():
            if name not in LIMITS:
                near = _or_remove(_nearest(name, LIMITS))
                yield _at(entry, "unread-key", "nothing reads it", near)
            kind = name.partition("_")[2]
            flag = f"has_{kind}_limits"
            if name.startswith(("min_", "max_")) and flag not in keys:
                yield _at(
                    entry,
                    "limit-without-flag",
                    f"ignored, as in ROS, without '{flag}: true'",
                    "write that beside it",
                )
            elif name in _NOT_ENFORCED and keys[flag].scalar is not False:
                yield _at(
                    entry,
                    "not-enforced",
                    "no drive of tool0 enforces it",
                    "",
                    "warning",
                )
