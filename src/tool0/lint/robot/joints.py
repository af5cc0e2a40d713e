"""Checks joints: types, limits, numbers and mimic joints."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tool0.description.finding import Finding, short
from tool0.lint.robot.elements import Tag, suggestion
from tool0.lint.robot.facts import MOVABLE, JointFacts, Robot, RobotFacts

_TYPES = (*MOVABLE, "fixed")
_LIMITED = ("revolute", "prismatic")
_FASTEST = {"revolute": 100.0, "continuous": 1000.0, "prismatic": 20.0}
"""Largest plausible velocity by joint type [rad/s | m/s].  The joints of arms turn at 3
rad/s, and those of grippers at 2 rad/s."""
_COUNTS: dict[str, dict[str, int]] = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), 1),
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "safety_controller": dict.fromkeys(
        ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"), 1
    ),
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"scale": 3},
}
"""Number of values in each attribute, by element and attribute."""


def joint_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the faults of single joints."""
    driven = robot.facts.driven_joints
    for joint in robot.root.children("joint"):
        name, kind = joint["name"], joint["type"]
        if kind not in _TYPES:
            yield joint.at.error(
                "unknown-joint-type",
                f"joint '{short(name)}' has the type '{short(kind)}', which URDF does "
                "not know, so ROS refuses the whole robot_description",
                suggestion(
                    kind, _TYPES, 'write type="{}"', f"write {', '.join(_TYPES)}"
                ),
            )
        axis = joint.child("axis")
        direction = axis.vector("xyz")
        if kind in MOVABLE and direction is not None and not any(direction):
            yield axis.at.error(
                "zero-axis",
                f"the axis of joint '{short(name)}' has no direction, so that it turns "
                "about none",
                'give it one, such as <axis xyz="0 0 1"/>',
            )
        if kind in _FASTEST:
            yield from _limit(joint, name, kind)
            if name in driven:  # an effort of 0 is common for joints without a drive
                yield from _no_power(joint.child("limit"), name)


def _limit(joint: Tag, name: str, kind: str) -> Iterator[Finding]:
    limit = joint.child("limit")
    if not limit:
        if kind in _LIMITED:
            yield joint.at.error(
                "no-limit",
                f"{kind} joint '{short(name)}' has no <limit>, so ROS refuses the "
                "whole robot_description",
                'write <limit lower="…" upper="…" effort="…" velocity="…"/>'
                + ("; without end is type continuous" * (kind == "revolute")),
            )
        return
    missing = [item for item in ("effort", "velocity") if not limit[item]]
    if missing:
        yield limit.at.error(
            "no-limit",
            f"the <limit> of joint '{short(name)}' lacks {' and '.join(missing)}, "
            "so ROS refuses the whole robot_description",
            "give it " + " ".join(f'{item}="…"' for item in missing),
        )
    lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
    if kind in _LIMITED and lower is not None and upper is not None:
        if lower > upper:
            yield limit.at.error(
                "limits-swapped",
                f"joint '{short(name)}' has its lower limit {lower:g} above its upper "
                f"{upper:g}: no position is allowed",
                f'write lower="{upper:g}" upper="{lower:g}"',
            )
        elif lower == upper:
            yield limit.at.warning(
                "no-range",
                f"joint '{short(name)}' may only be at {lower:g}, so it never moves; "
                "missing limits are 0",
                'give lower="…" and upper="…", or make it type="fixed"',
            )
    velocity = limit.number("velocity")
    if velocity is not None and velocity > _FASTEST[kind]:
        unit = "m/s" if kind == "prismatic" else "rad/s"
        yield limit.at.warning(
            "absurd-velocity",
            f"joint '{short(name)}' may move at {velocity:g} {unit}, so its limit "
            "protects nothing",
            f"give the real joint's speed in {unit}, not in degrees or mm",
        )


def _no_power(limit: Tag, name: str) -> Iterator[Finding]:
    for what in ("effort", "velocity"):
        value = limit.number(what)
        if value is not None and value <= 0:
            yield limit.at.error(
                "no-power",
                f"joint '{short(name)}' has the {what} limit {value:g}, to which "
                "ros_control clamps every command: it will never move",
                f'give the motor\'s {what}="…", above zero',
            )


def value_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the attributes of links and joints that are not valid numbers."""
    for kind in ("link", "joint"):
        for owner in robot.root.children(kind):
            for tag in owner.descendants():
                yield from _values(tag)


def _values(tag: Tag) -> Iterator[Finding]:
    for name, count in _COUNTS.get(tag.tag, {}).items():
        text = tag[name]
        words = text.split()
        if name not in tag or (len(words) == count and all(map(_is_number, words))):
            continue
        numbers = "a number" if count == 1 else f"{count} numbers"
        if "${" in text or "$(" in text:
            advice = "expand the file with xacro first: plain URDF has no expressions"
        elif "," in text:
            advice = f"write {numbers}, with spaces and a decimal point, no comma"
        else:
            advice = f"write {numbers}, in m, rad, kg, N, as in 0.5"
        yield tag.at.error(
            "not-a-number",
            f'<{tag.tag} {name}="{short(text)}"> of '
            f"'{short(tag.owner)}' is not {numbers} that a robot could have, so ROS "
            "refuses it, or takes it for another",
            advice,
        )


def _is_number(text: str) -> bool:
    """Return whether ROS reads ``text`` as a finite number of any size."""
    try:
        return math.isfinite(float(text)) and "_" not in text
    except ValueError:
        return False


def mimic_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the joints that mimic a joint that they cannot follow."""
    for joint in robot.facts.joints.values():
        if joint.mimic_of is not None:
            yield from _leader(joint, joint.mimic_of, robot.facts)


def _leader(joint: JointFacts, of: str, facts: RobotFacts) -> Iterator[Finding]:
    leader = facts.joints.get(of)
    mimics = f"joint '{short(joint.name)}' mimics '{short(of)}'"
    the_motor = "name the joint that has the motor"
    if leader is None:
        yield joint.at.error(
            "unknown-joint",
            f"{mimics}, which the robot "
            "lacks: robot_state_publisher and MoveIt refuse it, or leave it still",
            suggestion(of, facts.joints, 'write <mimic joint="{}"/>', the_motor),
        )
        return
    remedy = f"{the_motor} and mimics none, and multiply the multipliers"
    if _is_circle(joint, facts):
        yield joint.at.error(
            "mimic-circle",
            f"{mimics}, which comes back to itself: none of them is driven",
            remedy,
        )
    elif leader.mimic_of is not None:
        yield joint.at.warning(
            "mimic-chain",
            f"{mimics}, which mimics another: joint_state_publisher, MoveIt and "
            "the plugins for Gazebo each read such a chain in another way",
            remedy,
        )
    elif not (joint.is_movable and leader.is_movable):
        fixed = joint if not joint.is_movable else leader
        yield joint.at.warning(
            "mimic-fixed",
            f"{mimics}, but '{short(fixed.name)}' is {short(fixed.type)}: it cannot "
            "move",
            "remove <mimic>, or let both joints move",
        )


def _is_circle(joint: JointFacts, facts: RobotFacts) -> bool:
    seen: set[str] = set()
    follower: JointFacts | None = joint
    while follower is not None and follower.mimic_of is not None:
        if follower.name in seen:
            return True
        seen.add(follower.name)
        follower = facts.joints.get(follower.mimic_of)
    return False
