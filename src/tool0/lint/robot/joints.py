"""Joints that ROS cannot read, or that can never move: types, limits, axes."""

from __future__ import annotations

from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, warning_at
from tool0.description.xml_source import children
from tool0.errors import nearest_name
from tool0.lint.robot.elements import attribute, child, number, place, vector
from tool0.lint.robot.facts import MOVABLE, RobotFacts
from tool0.lint.robot.names import short

_TYPES = (*MOVABLE, "fixed")
_LIMITED = ("revolute", "prismatic")
_FASTEST = {"revolute": 100.0, "continuous": 1000.0, "prismatic": 20.0}
"""[rad/s | m/s]; an arm's joint turns at 3 rad/s, and a gripper's at 2."""


def joint_findings(root: Element, facts: RobotFacts) -> Iterator[Finding]:
    """Yield what is wrong in the joints themselves."""
    driven = facts.driven_joints
    for joint in children(root, "joint"):
        name, kind = attribute(joint, "name"), attribute(joint, "type")
        yield from _type(joint, name, kind)
        if kind in MOVABLE:
            yield from _axis(joint, name)
        if kind in _FASTEST:
            yield from _limit(joint, name, kind)
            if name in driven:  # 0 is what people write for one that nothing drives
                yield from _no_power(joint, name)


def _type(joint: Element, name: str, kind: str) -> Iterator[Finding]:
    if kind not in _TYPES:
        close = nearest_name(kind, _TYPES)
        yield error_at(
            place(joint),
            "unknown-joint-type",
            name,
            f"joint '{short(name)}' has the type '{short(kind)}', which URDF does "
            "not know, so ROS refuses the whole robot_description",
            f'write type="{close}"' if close else f"write {', '.join(_TYPES)}",
        )


def _axis(joint: Element, name: str) -> Iterator[Finding]:
    axis = child(joint, "axis")
    direction = vector(axis, "xyz")
    if axis is not None and direction is not None and not any(direction):
        yield error_at(
            place(axis),
            "zero-axis",
            name,
            f"the axis of joint '{short(name)}' has no direction, so that it turns "
            "about none",
            'give it one, such as <axis xyz="0 0 1"/>',
        )


def _limit(joint: Element, name: str, kind: str) -> Iterator[Finding]:
    limit = child(joint, "limit")
    needed = ("effort", "velocity")
    if limit is None:
        if kind in _LIMITED:
            yield error_at(
                place(joint),
                "no-limit",
                name,
                f"{kind} joint '{short(name)}' has no <limit>, so ROS refuses the "
                "whole robot_description",
                'write <limit lower="…" upper="…" effort="…" velocity="…"/>'
                + ("; without end is type continuous" * (kind == "revolute")),
            )
        return
    missing = [item for item in needed if not attribute(limit, item)]
    if missing:
        yield error_at(
            place(limit),
            "no-limit",
            name,
            f"the <limit> of joint '{short(name)}' lacks {' and '.join(missing)}, "
            "so ROS refuses the whole robot_description",
            "give it " + " ".join(f'{item}="…"' for item in missing),
        )
    yield from _range(limit, name, kind)
    velocity = number(limit, "velocity")
    if velocity is not None and velocity > _FASTEST[kind]:
        unit = "m/s" if kind == "prismatic" else "rad/s"
        yield warning_at(
            place(limit),
            "absurd-velocity",
            name,
            f"joint '{short(name)}' may move at {velocity:g} {unit}, so its limit "
            "stops nothing that goes wrong",
            f"give the real joint's speed in {unit}, not in degrees or mm",
        )


def _range(limit: Element, name: str, kind: str) -> Iterator[Finding]:
    if kind not in _LIMITED:
        return
    lower = number(limit, "lower") if attribute(limit, "lower") else 0.0
    upper = number(limit, "upper") if attribute(limit, "upper") else 0.0
    if lower is None or upper is None:
        return
    if lower > upper:
        yield error_at(
            place(limit),
            "limits-swapped",
            name,
            f"joint '{short(name)}' has its lower limit {lower:g} above its upper "
            f"{upper:g}: there is nowhere it may be",
            f'write lower="{upper:g}" upper="{lower:g}"',
        )
    elif lower == upper:
        yield warning_at(
            place(limit),
            "no-range",
            name,
            f"joint '{short(name)}' may only be at {lower:g}, so it never moves; "
            "what is not written is 0",
            'give lower="…" and upper="…", or make it type="fixed"',
        )


def _no_power(joint: Element, name: str) -> Iterator[Finding]:
    limit = child(joint, "limit")
    for what in ("effort", "velocity"):
        value = number(limit, what)
        if limit is not None and value is not None and value <= 0:
            yield error_at(
                place(limit),
                "no-power",
                name,
                f"joint '{short(name)}' has the {what} limit {value:g}, to which "
                "ros_control clamps every command: it will never move",
                f'give the motor\'s {what}="…", above zero',
            )
