"""Unused parameters of ros_control, which ROS ignores silently."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import final

from tool0.control.config import (
    TYPES,
    ControllerConfig,
    joint_limit_parameters,
    parameters_of,
    readers_of,
    siblings,
)
from tool0.control.parameters import joint_entries
from tool0.description.finding import Finding, Severity
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import is_typo, nearest_name

OF_TOOL0 = ("gazebo-only", "not-enforced")
"""Rules about differences between tool0 and Gazebo, which are no fault of the file."""
_JOINT_MAPPINGS = ("gains", "constraints", "velocity_ff")
"""Parameters whose keys are joints."""
_GAZEBO_GAINS = "gazebo_ros_control/pid_gains"


def gain_parameters() -> frozenset[str]:
    """Return the parameters of a joint's gains that are used."""
    read = parameters_of("effort_controllers/JointTrajectoryController")
    return frozenset(p.rpartition("/")[2] for p in read if p.startswith("gains/"))


def lint(
    config: ControllerConfig, joints: Collection[str] | None = None
) -> tuple[Finding, ...]:
    """Return unused, ineffective and suspicious parameters.

    ``joints`` are the robot's movable joints, if they are known.
    """
    findings = list(config.tree.findings)
    for name, entry in config.tree.root.children.items():
        if name not in config.names:
            findings += _lint_other(name, entry, joints)
        elif config.types[name] in TYPES:  # loading another type fails with a reason
            findings += _Controller(entry, config.types[name], joints).findings()
    return tuple(
        sorted(findings, key=lambda f: (str(f.location.file), f.location.line or 0))
    )


def _or_remove(near: str | None) -> str:
    """Return the remedy for an unknown name."""
    return f"did you mean '{near}'?" if near else "remove it"


def _severity(written: str, near: str | None) -> Severity:
    """Return an unknown name's severity: if no typo, another program may read it."""
    return "error" if is_typo(written, near) else "warning"


def _lint_other(
    name: str, entry: YamlEntry, known: Collection[str] | None
) -> Iterator[Finding]:
    """Yield findings about a top-level entry that is not a controller."""
    gains = entry.find("pid_gains")
    if gains is not None:
        yield _gazebo_gains(name, gains)
        yield from _unknown_joints(gains, known)
    elif name == "joint_limits":
        yield from _lint_limits(entry, known)
    elif name in {*gain_parameters(), *_JOINT_MAPPINGS, "joints", "joint", "type"}:
        yield entry.finding(
            "flat-yaml",
            "nothing reads it here; it belongs into a controller",
            "indent it",
        )
    elif name != "gazebo_ros_control":
        near = nearest_name("type", entry.children)
        yield entry.finding(
            "no-type",
            "nothing reads it: without a 'type' it is no controller",
            f"is '{near}' meant to be 'type'?" if near else "give it a type, or remove",
            _severity(near or "", "type"),
        )


def _gazebo_gains(name: str, gains: YamlEntry) -> Finding:
    if name == "gazebo_ros_control":
        return gains.finding(
            "gazebo-only",
            "read by Gazebo's gazebo_ros_control only; the servos of position and "
            "velocity joints need no gains here",
            severity="warning",
        )
    return gains.finding(
        "misplaced-key",
        "nothing reads it",
        f"gazebo_ros_control reads '{_GAZEBO_GAINS}', for position and velocity joints "
        "only",
    )


def _unknown_joints(
    names: YamlEntry, known: Collection[str] | None
) -> Iterator[Finding]:
    for name, entry in names.children.items():
        if known is not None and name not in known:
            unused = [joint for joint in known if joint not in names.children]
            yield entry.finding(
                "unknown-joint",
                f"the robot has no joint '{name}'",
                _or_remove(nearest_name(name, unused) or nearest_name(name, known)),
            )


def _lint_limits(limits: YamlEntry, known: Collection[str] | None) -> Iterator[Finding]:
    yield from _unknown_joints(limits, known)
    valid = joint_limit_parameters()
    for joint in limits.children.values():
        for name, entry in joint.children.items():
            if name not in valid:
                near = nearest_name(name, valid)
                yield entry.finding(
                    "unread-key",
                    "nothing reads it",
                    _or_remove(near),
                    _severity(name, near),
                )
            flag = f"has_{name.partition('_')[2]}_limits"
            if name.startswith(("min_", "max_")) and flag not in joint.children:
                yield entry.finding(
                    "limit-without-flag",
                    f"ignored, as in ROS, without '{flag}: true'",
                    "write that beside it",
                )


@final
@dataclass(frozen=True, slots=True)
class _Controller:
    """The parameters of one controller, whose type is known."""

    entry: YamlEntry
    type: str
    known_joints: Collection[str] | None
    """The robot's movable joints, if they are known."""

    @property
    def kind(self) -> str:
        return self.type.partition("/")[2]

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it names."""
        return tuple(str(item.scalar) for item in joint_entries(self.entry))

    def findings(self) -> Iterator[Finding]:
        """Yield parameters that the controller does not read or that have no effect."""
        read = parameters_of(self.type)
        reported: list[str] = []
        for leaf in self.entry.leaves():
            path = self._path(leaf)
            if path == "type" or path in read or self._pattern(path) in read:
                continue
            unread = self._outermost_unread(path)
            if unread.key not in reported:
                reported.append(unread.key)
                yield self._unread(unread)
        if any(pattern.endswith("/p") for pattern in read):
            yield from _idle_integrals(self.entry)

    def _path(self, entry: YamlEntry) -> str:
        return entry.key[len(self.entry.key) + 1 :]

    def _pattern(self, path: str) -> str:
        """Return ``path`` with ``*`` for the controller's joints."""
        joints = self.joints
        return "/".join("*" if part in joints else part for part in path.split("/"))

    def _outermost_unread(self, path: str) -> YamlEntry:
        """Return the outermost entry on ``path`` that is completely unused."""
        read = parameters_of(self.type)
        here = self.entry
        for part in path.split("/"):
            here = here.children[part]
            pattern = self._pattern(self._path(here))
            if not any(p == pattern or p.startswith(f"{pattern}/") for p in read):
                break
        return here

    def _unread(self, entry: YamlEntry) -> Finding:
        path, read = self._path(entry), parameters_of(self.type)
        first, _, rest = path.partition("/")
        is_by_joint = any(p.startswith(f"{first}/*") for p in read)
        if first in _JOINT_MAPPINGS and is_by_joint and rest and "/" not in rest:
            return self._not_a_joint(entry, first, rest)
        pattern = self._pattern(path)
        others = [kind for kind in readers_of(pattern) if kind != self.kind]
        if others:
            return entry.finding(
                "misplaced-key",
                f"{self.kind} does not read it; read by {' and '.join(others)} only",
                "remove it, or take that controller",
            )
        if first in ("gains", "velocity_ff", "pid") and "/" not in path:
            return entry.finding(
                "misplaced-key",
                f"{self.type} has no use for {first}: its interface needs no PID",
                "remove it",
            )
        written = path.rpartition("/")[2]
        near = nearest_name(written, siblings(pattern, read))
        return entry.finding(
            "unread-key",
            f"{self.kind} does not read it",
            _or_remove(near),
            _severity(written, near),
        )

    def _not_a_joint(self, entry: YamlEntry, mapping: str, name: str) -> Finding:
        is_unknown = self.known_joints is not None and name not in self.known_joints
        if mapping == "constraints" and name not in (self.known_joints or ()):
            near = nearest_name(name, ("goal_time", "stopped_velocity_tolerance"))
            if near is not None:
                remedy = f"did you mean '{near}'?"
                return entry.finding("unread-key", "nothing reads it", remedy)
        near = nearest_name(name, self.joints)
        remedy = _or_remove(near)
        if is_unknown:
            message = f"the robot has no joint '{name}'"
            return entry.finding("unknown-joint", message, remedy)
        message = f"'{name}' is not among the controller's joints"
        return entry.finding("unread-key", message, remedy, _severity(name, near))


def _idle_integrals(entry: YamlEntry) -> Iterator[Finding]:
    """Yield integral gains whose contribution is clamped to zero."""
    for gains in entry.children.values():
        yield from _idle_integrals(gains)
        keys = gains.children
        if "p" not in keys or not _number(keys.get("i")):
            continue
        clamps = [keys.get(k) for k in ("i_clamp", "i_clamp_min", "i_clamp_max")]
        if not any(map(_number, clamps)):
            yield keys["i"].finding(
                "idle-integral",
                "the integral contributes nothing, since i_clamp is "
                + ("0" if "i_clamp" in keys else "not given and hence 0"),
                "give i_clamp the largest effort that it may add, or leave i out",
                severity="warning",
            )


def _number(entry: YamlEntry | None) -> float:
    value = None if entry is None else entry.scalar
    return float(value) if isinstance(value, int | float) else 0.0
