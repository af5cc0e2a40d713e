"""Parameters of a controller that it does not read, or that do nothing."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import final

from tool0.control.parameter_tables import parameters_of, readers_of
from tool0.description.finding import Finding, Severity
from tool0.description.yaml_tree import Entry
from tool0.errors import nearest_name

JOINT_MAPPINGS = ("gains", "constraints", "velocity_ff")
"""Namespaces whose keys are joints."""


def complaint(
    entry: Entry,
    rule: str,
    message: str,
    remedy: str,
    severity: Severity = "error",
) -> Finding:
    """Return a finding about ``entry``."""
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


def controller_findings(
    entry: Entry, known: Collection[str] | None
) -> Iterator[Finding]:
    """Yield what the controller of a namespace does not read, or reads in vain.

    Args:
        entry: The namespace, which has a ``type``.
        known: The robot's movable joints, if they are known.
    """
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
    is_by_joint = first in JOINT_MAPPINGS and reader.is_by_joint(first)
    if is_by_joint and rest and "/" not in rest:
        near = None
        if first == "constraints" and rest not in (known or ()):
            near = nearest_name(rest, ("goal_time", "stopped_velocity_tolerance"))
        if near is None:
            return _not_a_joint(entry, rest, reader.joints, known)
        return complaint(
            entry, "unread-key", "nothing reads it", f"did you mean '{near}'?"
        )
    pattern = reader.pattern(path)
    others = [kind for kind in readers_of(pattern) if kind != reader.kind]
    if others:
        return complaint(
            entry,
            "misplaced-key",
            f"{reader.kind} does not read it; read by {' and '.join(others)} only",
            "remove it, or take that controller",
        )
    if first in ("gains", "velocity_ff", "pid") and "/" not in path:
        return complaint(
            entry,
            "misplaced-key",
            f"{reader.type_name} has no use for {first}: its interface needs no PID",
            "remove it",
        )
    near = nearest_name(path.rpartition("/")[2], _siblings(pattern, reader.patterns))
    return complaint(
        entry, "unread-key", f"{reader.kind} does not read it", or_remove(near)
    )


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
    near = or_remove(nearest_name(name, joints))
    if known is not None and name not in known:
        return complaint(
            entry, "unknown-joint", f"the robot has no joint '{name}'", near
        )
    message = f"'{name}' is not among the controller's joints"
    return complaint(entry, "unread-key", message, near)


def or_remove(near: str | None) -> str:
    """Return the remedy for a name that nothing knows."""
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
            yield complaint(
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
