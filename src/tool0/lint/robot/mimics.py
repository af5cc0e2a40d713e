"""Joints that mimic others: whom they follow, and what makes them follow in Gazebo."""

from __future__ import annotations

from collections.abc import Iterator

from tool0.description.finding import Finding, error_at, short, warning_at
from tool0.errors import nearest_name
from tool0.lint.robot.bodies import bodies
from tool0.lint.robot.facts import JointFacts, RobotFacts


def mimic_findings(facts: RobotFacts, spawned: bool) -> Iterator[Finding]:
    """Yield what is wrong in mimic joints."""
    for joint in facts.joints.values():
        if joint.mimic_of is not None:
            yield from _leader(joint, facts)
    if (facts.transmissions or facts.control_plugins or spawned) and (
        not facts.ros2_joints
    ):
        yield from _loose(facts)
    yield from _teleported(facts)


def _leader(joint: JointFacts, facts: RobotFacts) -> Iterator[Finding]:
    of = joint.mimic_of or ""
    leader = facts.joints.get(of)
    if leader is None:
        close = nearest_name(of, facts.joints)
        yield error_at(
            joint.location,
            "unknown-joint",
            joint.name,
            f"joint '{short(joint.name)}' mimics '{short(of)}', which the robot "
            "lacks: robot_state_publisher and MoveIt refuse it, or leave it still",
            f'write <mimic joint="{close}"/>'
            if close
            else "name the joint that has the motor",
        )
        return
    circle = _is_circle(joint, facts)
    if circle or leader.mimic_of is not None:
        finding_at = error_at if circle else warning_at
        yield finding_at(
            joint.location,
            "mimic-circle" if circle else "mimic-chain",
            joint.name,
            f"joint '{short(joint.name)}' mimics '{short(of)}'"
            + (
                ", which comes back to itself: none of them is driven"
                if circle
                else ", which mimics another: joint_state_publisher, MoveIt and "
                "the plugins for Gazebo each read such a chain in another way"
            ),
            "name the joint that has the motor and mimics none, and multiply "
            "the multipliers",
        )
    elif not (joint.is_movable and leader.is_movable):
        fixed = joint if not joint.is_movable else leader
        yield warning_at(
            joint.location,
            "mimic-fixed",
            joint.name,
            f"joint '{short(joint.name)}' mimics '{short(of)}', but "
            f"'{short(fixed.name)}' is {short(fixed.type)}: it cannot move",
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


def _loose(facts: RobotFacts) -> Iterator[Finding]:
    body = bodies(facts)
    geared = {
        body.get(link) for box in facts.gearboxes for link in (box.parent, box.child)
    }
    held = facts.mimic_plugin_joints | facts.driven_joints | facts.passive_joints
    for joint in facts.joints.values():
        if joint.mimic_of is None or not joint.is_movable or joint.name in held:
            continue
        if body.get(joint.child) not in geared:
            yield warning_at(
                joint.location,
                "loose-mimic",
                joint.name,
                f"joint '{short(joint.name)}' mimics '{short(joint.mimic_of)}', "
                "but Gazebo classic drops <mimic>: it swings freely, and the "
                "fingers neither follow nor hold",
                "hold it with a gearbox joint, "
                '<gazebo><joint type="gearbox">…</joint></gazebo> (ODE only), as '
                "tool0_description does, or with a mimic plugin that has <hasPID/>",
            )


def _teleported(facts: RobotFacts) -> Iterator[Finding]:
    for plugin in facts.plugins:
        if not plugin.is_mimic or "roboticsgroup" not in plugin.filename:
            continue
        if plugin.parameter("hasPID") is None:
            joint = plugin.parameter("mimicJoint") or plugin.name
            yield warning_at(
                plugin.location,
                "teleported-mimic",
                joint,
                f"without <hasPID/> the mimic plugin '{short(plugin.name)}' sets "
                f"the position of '{short(joint)}' at every step: the finger "
                "feels no contact, so what it grasps is thrown away or dropped",
                "hold the joint with a gearbox joint as tool0_description does, "
                "or add <hasPID/> and gains under "
                f"gazebo_ros_control/pid_gains/{short(joint)}",
            )
