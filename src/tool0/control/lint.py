"""Warnings about parameters that do nothing: ROS ignores them without a word."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator

from tool0.control.config import ControllerConfig
from tool0.control.parameter_tables import (
    GAINS,
    LIMITS,
    parameters_of,
    readers_of,
)
from tool0.description.model import RobotModel
from tool0.description.yaml_tree import ConfigWarning, Entry, warning_at

_GAZEBO_GAINS = "gazebo_ros_control/pid_gains"
_NOT_ENFORCED = ("max_acceleration", "max_jerk")
_JOINT_MAPPINGS = ("gains", "constraints", "velocity_ff")


def lint(
    config: ControllerConfig, model: RobotModel | None = None
) -> tuple[ConfigWarning, ...]:
    """Return a warning for every parameter that nothing reads, or that does nothing.

    Args:
        config: A person's parameters.
        model: The robot, to find names of joints that it lacks.
    """
    joints = None if model is None else {j.name for j in model.movable_joints}
    warnings = list(config.warnings)
    for name, entry in (config.tree.root.children or {}).items():
        if name in config.names:
            warnings += _lint_controller(entry, joints)
        else:
            warnings += _lint_other(name, entry, joints)
    return tuple(sorted(warnings, key=lambda item: (item.file, item.line or 0)))


def _lint_controller(
    entry: Entry, known: Collection[str] | None
) -> Iterator[ConfigWarning]:
    type_entry = (entry.children or {})["type"]
    try:
        patterns = parameters_of(str(type_entry.scalar))
    except KeyError:
        return  # loading it says so
    joints = _joints_of(entry)
    reported: list[str] = []
    for leaf in entry.leaves():
        path = leaf.key[len(entry.key) + 1 :]
        if path == "type" or _is_read(path, patterns, joints):
            continue
        where = _outermost_unread(entry, path, patterns, joints)
        if where.key in reported:
            continue
        reported.append(where.key)
        path = where.key[len(entry.key) + 1 :]
        yield warning_at(
            where, _why_unread(path, str(type_entry.scalar), patterns, joints, known)
        )
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


def _is_read(path: str, patterns: frozenset[str], joints: tuple[str, ...]) -> bool:
    return path in patterns or _pattern_of(path, joints) in patterns


def _pattern_of(path: str, joints: Collection[str]) -> str:
    return "/".join("*" if part in joints else part for part in path.split("/"))


def _outermost_unread(
    entry: Entry, path: str, patterns: frozenset[str], joints: tuple[str, ...]
) -> Entry:
    """Return the namespace nearest to the controller of which nothing is read."""
    here = entry
    for part in path.split("/"):
        here = (here.children or {})[part]
        inner = here.key[len(entry.key) + 1 :]
        pattern = _pattern_of(inner, joints)
        if not any(
            candidate == pattern or candidate.startswith(f"{pattern}/")
            for candidate in patterns
        ):
            break
    return here


def _why_unread(
    path: str,
    type_name: str,
    patterns: frozenset[str],
    joints: tuple[str, ...],
    known: Collection[str] | None,
) -> str:
    kind = type_name.partition("/")[2]
    first, _, rest = path.partition("/")
    is_by_joint = any(pattern.startswith(f"{first}/*") for pattern in patterns)
    if first in _JOINT_MAPPINGS and is_by_joint and rest and "/" not in rest:
        near = ""
        if first == "constraints" and rest not in (known or ()):
            near = _nearest(rest, ("goal_time", "stopped_velocity_tolerance"))
        return f"nothing reads it{near}" if near else _not_a_joint(rest, joints, known)
    pattern = _pattern_of(path, joints)
    readers = [reader for reader in readers_of(pattern) if reader != kind]
    if readers:
        return f"{kind} does not read it; read by {' and '.join(readers)} only"
    if first in ("gains", "velocity_ff", "pid") and "/" not in path:
        return f"{type_name} has no use for {first}: its interface needs no PID"
    siblings = _siblings(pattern, patterns)
    return f"{kind} does not read it{_nearest(path.rpartition('/')[2], siblings)}"


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
    name: str, joints: tuple[str, ...], known: Collection[str] | None
) -> str:
    if known is not None and name not in known:
        return f"the robot has no joint '{name}'{_nearest(name, joints)}"
    return f"'{name}' is not among the controller's joints{_nearest(name, joints)}"


def _nearest(name: str, valid: Collection[str]) -> str:
    close = difflib.get_close_matches(name, sorted(valid), n=1, cutoff=0.6)
    return f"; did you mean '{close[0]}'?" if close else ""


def _idle_integrals(entry: Entry, patterns: frozenset[str]) -> Iterator[ConfigWarning]:
    """Warn of integral gains whose contribution is clamped to zero."""
    if not any(pattern.endswith("/p") for pattern in patterns):
        return
    for gains in _mappings(entry):
        keys = gains.children or {}
        if "p" not in keys or not _number(keys.get("i")):
            continue
        clamps = [keys.get(k) for k in ("i_clamp", "i_clamp_min", "i_clamp_max")]
        if not any(map(_number, clamps)):
            yield warning_at(
                keys["i"],
                "the integral contributes nothing, since i_clamp is "
                + ("0" if "i_clamp" in keys else "not given and hence 0"),
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
) -> Iterator[ConfigWarning]:
    """Warn of what stands at the top and is no controller."""
    children = entry.children or {}
    gains = children.get("pid_gains")
    if gains is not None and name == "gazebo_ros_control":
        yield warning_at(
            gains,
            "read by Gazebo's gazebo_ros_control only; the servos of position and "
            "velocity joints need no gains here",
        )
        yield from _unknown_joints(gains, known)
    elif gains is not None:
        yield warning_at(
            gains,
            f"nothing reads it; gazebo_ros_control reads '{_GAZEBO_GAINS}', and the "
            "servos of position and velocity joints need no gains here",
        )
        yield from _unknown_joints(gains, known)
    elif name == "joint_limits":
        yield from _lint_limits(entry, known)
    elif name in GAINS | set(_JOINT_MAPPINGS) | {"joints", "joint", "type"}:
        yield warning_at(
            entry, "nothing reads it here; it belongs into a controller: indent it"
        )
    elif name != "gazebo_ros_control":
        near = difflib.get_close_matches("type", list(children), n=1, cutoff=0.6)
        yield warning_at(
            entry,
            "nothing reads it: without a 'type' it is no controller"
            + (f"; is '{near[0]}' meant to be 'type'?" if near else ""),
        )


def _unknown_joints(
    gains: Entry, known: Collection[str] | None
) -> Iterator[ConfigWarning]:
    for name, entry in (gains.children or {}).items():
        if known is not None and name not in known:
            yield warning_at(
                entry, f"the robot has no joint '{name}'{_nearest(name, known)}"
            )


def _lint_limits(
    limits: Entry, known: Collection[str] | None
) -> Iterator[ConfigWarning]:
    yield from _unknown_joints(limits, known)
    for joint in (limits.children or {}).values():
        keys = joint.children or {}
        for name, entry in keys.items():
            if name not in LIMITS:
                yield warning_at(entry, f"nothing reads it{_nearest(name, LIMITS)}")
            kind = name.partition("_")[2]
            flag = f"has_{kind}_limits"
            if name.startswith(("min_", "max_")) and flag not in keys:
                yield warning_at(entry, f"ignored, as in ROS, without '{flag}: true'")
            elif name in _NOT_ENFORCED and keys[flag].scalar is not False:
                yield warning_at(entry, "no drive of tool0 enforces it")
