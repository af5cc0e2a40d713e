"""Checks Gazebo's elements: plugins, references, and the coupling of mimic joints."""

from __future__ import annotations

from collections.abc import Iterator

from tool0.description.finding import Finding, quoted, short
from tool0.errors import nearest_name
from tool0.lint.robot.elements import suggestion
from tool0.lint.robot.facts import PluginFacts, Robot, RobotFacts

LIBRARY = "libgazebo_ros_control.so"
_FILES = (LIBRARY, LIBRARY.removeprefix("lib"), LIBRARY.removesuffix(".so"))
_PARAMETERS_OF_CONTROL = (
    *("robotNamespace", "robotSimType", "controlPeriod", "robotParam"),
    *("legacyModeNS", "eStopTopic"),
)
_PARAMETERS_OF_MIMIC = (
    *("joint", "mimicJoint", "multiplier", "offset", "maxEffort", "sensitiveness"),
    *("robotNamespace", "hasPID"),
)


def plugin_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the faults of the Gazebo plugins."""
    facts = robot.facts
    yield from _two(facts)
    if (
        facts.transmissions
        and (robot.is_spawned or facts.plugins)
        and not any(p.is_control or p.is_control_of_ros2 for p in facts.plugins)
    ):
        yield facts.transmissions[0].at.warning(
            "no-plugin",
            f"the robot has transmissions, yet no {LIBRARY}: in Gazebo there is no "
            "controller manager, spawners wait for it forever and the arm falls",
            f'add <gazebo><plugin name="ros_control" filename="{LIBRARY}"/></gazebo>',
            key=facts.name,
        )
    for plugin in facts.plugins:
        yield from _file(plugin)
        if plugin.is_control:
            yield from _parameters(plugin, _PARAMETERS_OF_CONTROL)
        elif _is_upatras_mimic(plugin):
            yield from _parameters(plugin, _PARAMETERS_OF_MIMIC)
            yield from _joints(plugin, facts)


def _is_upatras_mimic(plugin: PluginFacts) -> bool:
    return plugin.is_mimic and "roboticsgroup" in plugin.filename


def _two(facts: RobotFacts) -> Iterator[Finding]:
    first: dict[str, PluginFacts] = {}
    for plugin in facts.control_plugins:
        description = plugin.parameter("robotParam") or "robot_description"
        earlier = first.setdefault(description.strip("/"), plugin)
        if earlier is plugin:
            continue
        where = (
            "made by the same line, of a macro that is called twice"
            if plugin.at.location == earlier.at.location
            else f"at {earlier.at.location}"
        )
        yield plugin.at.error(
            "two-plugins",
            f"a second {LIBRARY}, '{short(plugin.at.key)}'; the first, "
            f"'{short(earlier.at.key)}', is {where}. Each makes a "
            "controller manager for every joint of the robot: their commands "
            "fight over the joints, and in one namespace the services of one "
            "hide those of the other",
            "keep one; an arm's and a gripper's macro often bring one each: "
            "remove the gripper's",
        )


def _file(plugin: PluginFacts) -> Iterator[Finding]:
    file = plugin.filename
    if not file:
        yield plugin.at.error(
            "unnamed",
            "this <plugin> names no file, so Gazebo loads nothing",
            f'write filename="…", such as filename="{LIBRARY}"',
            key="<plugin>",
        )
    elif plugin.is_control_of_ros2 or file.rpartition("/")[2] in _FILES:
        return
    elif plugin.is_control or nearest_name(file, (LIBRARY,), cutoff=0.9):
        yield plugin.at.error(
            "unknown-plugin",
            f"there is no plugin '{short(file)}', so Gazebo has no controller manager",
            f'write filename="{LIBRARY}"',
        )


def _parameters(plugin: PluginFacts, known: tuple[str, ...]) -> Iterator[Finding]:
    for at, _ in plugin.parameters:
        if at.key not in known:
            close = nearest_name(at.key, known)
            yield at.error(
                "unread-parameter",
                f"the plugin {short(plugin.filename)} does not read "
                f"<{short(at.key)}>, so it does nothing",
                f"write <{close}>" if close else f"it reads {quoted(known)}",
                severity="error" if close else "warning",
            )


def _joints(plugin: PluginFacts, facts: RobotFacts) -> Iterator[Finding]:
    places = {at.key: at for at, _ in plugin.parameters}
    for role in ("joint", "mimicJoint"):
        name = plugin.parameter(role) or ""
        if name not in facts.joints:
            yield places.get(role, plugin.at).error(
                "unknown-joint",
                f"plugin '{short(plugin.at.key)}' has the <{role}> '{short(name)}'"
                ", which the robot lacks: it does nothing, and the finger hangs loose",
                suggestion(
                    name,
                    facts.joints,
                    f"write <{role}>{{}}</{role}>",
                    "name one of the robot's joints",
                ),
                key=name or plugin.at.key,
            )


def extension_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the extensions that refer to missing elements."""
    known = {**robot.facts.links, **robot.facts.joints}
    for extension in robot.root.children("gazebo"):
        name = extension["reference"]
        if name and name not in known:
            yield extension.at.warning(
                "unknown-reference",
                f'<gazebo reference="{short(name)}"> is about neither a link nor '
                "a joint of the robot, so it does nothing",
                suggestion(name, known, 'write reference="{}"', "remove it"),
                key=name,
            )
    for gearbox in robot.facts.gearboxes:
        for role, name in (("parent", gearbox.parent), ("child", gearbox.child)):
            merged = robot.body.get(name)
            if merged == name:
                continue
            reason, remedy = "the robot lacks", "name one of its links"
            close = nearest_name(name, robot.facts.links) if merged is None else merged
            if merged is not None:
                reason = f"Gazebo has merged into '{short(merged)}'"
            yield gearbox.at.error(
                "unknown-link",
                f"gearbox '{short(gearbox.at.key)}' has the {role} '{short(name)}', "
                f"which {reason}: Gazebo does not make the gearbox, and the "
                "finger hangs loose",
                f"write <{role}>{close}</{role}>" if close else remedy,
            )


def follower_findings(robot: Robot) -> Iterator[Finding]:
    """Yield mimic joints that follow no joint, or whose position a plugin sets."""
    if robot.is_controlled and not robot.facts.ros2_joints:
        yield from _loose(robot)
    for plugin in filter(_is_upatras_mimic, robot.facts.plugins):
        if plugin.parameter("hasPID") is None:
            joint = plugin.parameter("mimicJoint") or plugin.at.key
            yield plugin.at.warning(
                "teleported-mimic",
                f"without <hasPID/> the mimic plugin '{short(plugin.at.key)}' sets "
                f"the position of '{short(joint)}' at every step: the finger "
                "feels no contact, so what it grasps is thrown away or dropped",
                "hold the joint with a gearbox joint as tool0_description does, "
                "or add <hasPID/> and gains under "
                f"gazebo_ros_control/pid_gains/{short(joint)}",
                key=joint,
            )


def _loose(robot: Robot) -> Iterator[Finding]:
    facts, body = robot.facts, robot.body
    if not robot.is_controlled or facts.ros2_joints:
        return  # the robot is not for Gazebo classic of ROS 1
    geared = {
        body.get(link) for box in facts.gearboxes for link in (box.parent, box.child)
    }
    held = facts.driven_joints | facts.passive_joints
    held |= {p.parameter("mimicJoint") or "" for p in facts.plugins if p.is_mimic}
    for joint in facts.joints.values():
        if joint.mimic_of is None or not joint.is_movable or joint.name in held:
            continue
        if body.get(joint.child) not in geared:
            yield joint.at.warning(
                "loose-mimic",
                f"joint '{short(joint.name)}' mimics '{short(joint.mimic_of)}', "
                "but Gazebo classic drops <mimic>: it swings freely, and the "
                "fingers neither follow nor hold",
                "hold it with a gearbox joint, "
                '<gazebo><joint type="gearbox">…</joint></gazebo> (ODE only), as '
                "tool0_description does, or with a mimic plugin that has <hasPID/>",
            )
