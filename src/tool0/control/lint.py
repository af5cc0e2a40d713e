"""Parameters that do nothing: ROS ignores them without a word."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from tool0.control.config import ControllerConfig
from tool0.control.lint_controller import (
    JOINT_MAPPINGS,
    complaint,
    controller_findings,
    or_remove,
)
from tool0.control.parameter_tables import GAINS, LIMITS
from tool0.description.finding import Finding
from tool0.description.model import RobotModel
from tool0.description.yaml_tree import Entry
from tool0.errors import nearest_name

OF_TOOL0 = ("gazebo-only", "not-enforced")
"""Rules that tell what tool0 does otherwise than Gazebo: no fault of the file."""
_GAZEBO_GAINS = "gazebo_ros_control/pid_gains"
_NOT_ENFORCED = ("max_acceleration", "max_jerk")


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
            findings += controller_findings(entry, joints)
        else:
            findings += _lint_other(name, entry, joints)
    return tuple(sorted(findings, key=_place))


def _place(finding: Finding) -> tuple[str, int]:
    return str(finding.location.file), finding.location.line or 0


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
    elif name in GAINS | set(JOINT_MAPPINGS) | {"joints", "joint", "type"}:
        yield complaint(
            entry,
            "flat-yaml",
            "nothing reads it here; it belongs into a controller",
            "indent it",
        )
    elif name != "gazebo_ros_control":
        near = nearest_name("type", list(children))
        yield complaint(
            entry,
            "no-type",
            "nothing reads it: without a 'type' it is no controller",
            f"is '{near}' meant to be 'type'?" if near else "give it a type, or remove",
        )


def _gazebo_gains(name: str, gains: Entry) -> Finding:
    if name == "gazebo_ros_control":
        return complaint(
            gains,
            "gazebo-only",
            "read by Gazebo's gazebo_ros_control only; the servos of position and "
            "velocity joints need no gains here",
            "",
            "warning",
        )
    return complaint(
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
            yield complaint(
                entry,
                "unknown-joint",
                f"the robot has no joint '{name}'",
                or_remove(nearest_name(name, unused) or nearest_name(name, known)),
            )


def _lint_limits(limits: Entry, known: Collection[str] | None) -> Iterator[Finding]:
    yield from _unknown_joints(limits, known)
    for joint in (limits.children or {}).values():
        keys = joint.children or {}
        for name, entry in keys.items():
            if name not in LIMITS:
                near = or_remove(nearest_name(name, LIMITS))
                yield complaint(entry, "unread-key", "nothing reads it", near)
            kind = name.partition("_")[2]
            flag = f"has_{kind}_limits"
            if name.startswith(("min_", "max_")) and flag not in keys:
                yield complaint(
                    entry,
                    "limit-without-flag",
                    f"ignored, as in ROS, without '{flag}: true'",
                    "write that beside it",
                )
            elif name in _NOT_ENFORCED and keys[flag].scalar is not False:
                yield complaint(
                    entry,
                    "not-enforced",
                    "no drive of tool0 enforces it",
                    "",
                    "warning",
                )
