"""Linting of YAML for ros_control: unused parameters, which ROS silently ignores."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from tool0.control.controller_lint import (
    JOINT_MAPPINGS,
    ControllerLint,
    limit_findings,
    severity_of,
    unknown_joints,
)
from tool0.control.ros1.dialect import ROS1
from tool0.description.finding import Finding
from tool0.description.yaml_tree import Tree, YamlEntry
from tool0.errors import nearest_name

OF_TOOL0 = ("gazebo-only", "not-enforced")
"""Rules for differences between tool0 and Gazebo; such differences are not errors in
the file."""
_GAZEBO_GAINS = "gazebo_ros_control/pid_gains"


def gain_parameters() -> frozenset[str]:
    """Return the parameter names that are read from the gains of a joint."""
    read = ROS1.parameters_of("effort_controllers/JointTrajectoryController")
    return frozenset(p.rpartition("/")[2] for p in read if p.startswith("gains/"))


def lint(tree: Tree, joints: Collection[str] | None = None) -> tuple[Finding, ...]:
    """Return findings about unused, ineffective and suspicious parameters.

    ``joints`` are the robot's movable joints; None if they are unknown.
    """
    findings = list(tree.findings)
    declared = ROS1.declared(tree.root)
    for name, entry in tree.root.children.items():
        kind = declared[name].type.scalar if name in declared else None
        if name not in declared:
            findings += _lint_other(name, entry, joints)
        elif str(kind) in ROS1.types:  # loading of other types fails with a reason
            controller = ControllerLint(ROS1, entry, str(kind), joints)
            findings += controller.findings()
            if any(p.endswith("/p") for p in ROS1.parameters_of(str(kind))):
                findings += _idle_integrals(entry)
    return tuple(
        sorted(findings, key=lambda f: (str(f.location.file), f.location.line or 0))
    )


def _lint_other(
    name: str, entry: YamlEntry, known: Collection[str] | None
) -> Iterator[Finding]:
    """Yield findings about a top-level entry that is not a controller."""
    gains = entry.find("pid_gains")
    if gains is not None:
        yield _gazebo_gains(name, gains)
        yield from unknown_joints(gains, known)
    elif name == "joint_limits":
        yield from limit_findings(entry, known)
    elif name in {*gain_parameters(), *JOINT_MAPPINGS, "joints", "joint", "type"}:
        yield entry.finding(
            "flat-yaml",
            "nothing reads it here; it belongs in a controller",
            "indent it",
        )
    elif name != "gazebo_ros_control":
        near = nearest_name("type", entry.children)
        yield entry.finding(
            "no-type",
            "nothing reads it: without a 'type' it is no controller",
            f"is '{near}' meant to be 'type'?" if near else "give it a type, or remove",
            severity_of(near or "", "type"),
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


def _idle_integrals(entry: YamlEntry) -> Iterator[Finding]:
    """Yield findings about integral gains that contribute nothing due to the clamp."""
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
