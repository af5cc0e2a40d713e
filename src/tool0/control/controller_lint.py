"""Linting of unused controller parameters, which ROS 1 and ROS 2 ignore."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import final

from tool0.control.dialect import Dialect, siblings
from tool0.control.joint_limits import joint_limit_parameters
from tool0.control.parameters import joint_entries
from tool0.description.finding import Finding, Severity
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import is_typo, nearest_name

JOINT_MAPPINGS = ("gains", "constraints", "velocity_ff")
"""Parameters that map joint names to values."""


def or_remove(near: str | None) -> str:
    """Return the suggested remedy for an unknown name."""
    return f"did you mean '{near}'?" if near else "remove it"


def severity_of(written: str, near: str | None) -> Severity:
    """Return the severity of an unknown name.

    If the name does not look like a typo, the severity is only a warning, since other
    programs may read the name.
    """
    return "error" if is_typo(written, near) else "warning"


def unknown_joints(
    names: YamlEntry, known: Collection[str] | None
) -> Iterator[Finding]:
    """Yield the keys of a mapping that are not joints of the robot."""
    for name, entry in names.children.items():
        if known is not None and name not in known:
            unused = [joint for joint in known if joint not in names.children]
            yield entry.finding(
                "unknown-joint",
                f"the robot has no joint '{name}'",
                or_remove(nearest_name(name, unused) or nearest_name(name, known)),
            )


def limit_findings(
    limits: YamlEntry, known: Collection[str] | None
) -> Iterator[Finding]:
    """Yield errors in the limits that override the limits of the URDF."""
    yield from unknown_joints(limits, known)
    valid = joint_limit_parameters()
    for joint in limits.children.values():
        for name, entry in joint.children.items():
            if name not in valid:
                near = nearest_name(name, valid)
                yield entry.finding(
                    "unread-key",
                    "nothing reads it",
                    or_remove(near),
                    severity_of(name, near),
                )
            flag = f"has_{name.partition('_')[2]}_limits"
            if name.startswith(("min_", "max_")) and flag not in joint.children:
                yield entry.finding(
                    "limit-without-flag",
                    f"ignored, as in ROS, without '{flag}: true'",
                    "write that next to it",
                )


@final
@dataclass(frozen=True, slots=True)
class ControllerLint:
    """The parameters of one controller of a known type."""

    dialect: Dialect
    entry: YamlEntry
    type: str
    known_joints: Collection[str] | None
    """The robot's movable joints; None if they are unknown."""

    @property
    def kind(self) -> str:
        return self.type.partition("/")[2]

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that the controller's parameters list."""
        return tuple(str(item.scalar) for item in joint_entries(self.entry))

    def findings(self) -> Iterator[Finding]:
        """Yield findings about parameters that the controller does not read."""
        read = self.dialect.parameters_of(self.type)
        reported: list[str] = []
        for leaf in self.entry.leaves():
            path = self._path(leaf)
            if self._is_read(path, read):
                continue
            unread = self._outermost_unread(path)
            if unread.key not in reported:
                reported.append(unread.key)
                yield self._unread(unread)

    def _is_read(self, path: str, read: frozenset[str]) -> bool:
        """Return whether a parameter, or a parameter that contains it, is read."""
        first, pattern = path.partition("/")[0], self._pattern(path)
        return first in self.dialect.common or any(
            pattern == known or pattern.startswith(f"{known}/") for known in read
        )

    def pattern_of(self, entry: YamlEntry) -> str:
        """Return the path of ``entry``, with ``*`` in place of controller joints."""
        return self._pattern(self._path(entry))

    def _path(self, entry: YamlEntry) -> str:
        return entry.key[len(self.entry.key) + 1 :]

    def _pattern(self, path: str) -> str:
        """Return ``path``, in which ``*`` replaces controller joints."""
        joints = self.joints
        return "/".join("*" if part in joints else part for part in path.split("/"))

    def _outermost_unread(self, path: str) -> YamlEntry:
        """Return the outermost entry on ``path`` that is completely unused."""
        read = self.dialect.parameters_of(self.type)
        here = self.entry
        for part in path.split("/"):
            here = here.children[part]
            pattern = self._pattern(self._path(here))
            if not any(p == pattern or p.startswith(f"{pattern}/") for p in read):
                break
        return here

    def _unread(self, entry: YamlEntry) -> Finding:
        path, read = self._path(entry), self.dialect.parameters_of(self.type)
        first, _, rest = path.partition("/")
        is_by_joint = any(p.startswith(f"{first}/*") for p in read)
        if first in JOINT_MAPPINGS and is_by_joint and rest and "/" not in rest:
            return self._not_a_joint(entry, first, rest)
        pattern = self._pattern(path)
        others = [
            kind for kind in self.dialect.readers_of(pattern) if kind != self.kind
        ]
        if others:
            return entry.finding(
                "misplaced-key",
                f"{self.kind} does not read it; read by {' and '.join(others)} only",
                "remove it, or use that controller",
                "warning",
            )
        if first in ("gains", "velocity_ff", "pid") and "/" not in path:
            return entry.finding(
                "misplaced-key",
                f"{self.type} has no use for {first}: its interface needs no PID",
                "remove it",
                "warning",
            )
        written = path.rpartition("/")[2]
        near = nearest_name(written, siblings(pattern, read))
        return entry.finding(
            "unread-key",
            f"{self.kind} does not read it",
            or_remove(near),
            severity_of(written, near),
        )

    def _not_a_joint(self, entry: YamlEntry, mapping: str, name: str) -> Finding:
        is_unknown = self.known_joints is not None and name not in self.known_joints
        if mapping == "constraints" and name not in (self.known_joints or ()):
            near = nearest_name(name, ("goal_time", "stopped_velocity_tolerance"))
            if near is not None:
                remedy = f"did you mean '{near}'?"
                return entry.finding("unread-key", "nothing reads it", remedy)
        near = nearest_name(name, self.joints)
        remedy = or_remove(near)
        if is_unknown:
            message = f"the robot has no joint '{name}'"
            return entry.finding("unknown-joint", message, remedy)
        message = f"'{name}' is not among the controller's joints"
        return entry.finding("unread-key", message, remedy, severity_of(name, near))
