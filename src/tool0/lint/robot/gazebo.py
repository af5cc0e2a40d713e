"""Gazebo's <gazebo> elements: controller managers, misspelt parameters, references."""

from __future__ import annotations

from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, quoted, short, warning_at
from tool0.description.xml_source import children
from tool0.errors import nearest_name
from tool0.lint.robot.bodies import bodies
from tool0.lint.robot.elements import attribute, place
from tool0.lint.robot.facts import PluginFacts, RobotFacts

LIBRARY = "libgazebo_ros_control.so"
_FILES = (LIBRARY, LIBRARY.removeprefix("lib"), LIBRARY.removesuffix(".so"))
_CONTROL = (
    "robotNamespace",
    "robotSimType",
    "controlPeriod",
    "robotParam",
    "legacyModeNS",
    "eStopTopic",
)
_MIMIC = (
    "joint",
    "mimicJoint",
    "multiplier",
    "offset",
    "maxEffort",
    "sensitiveness",
    "robotNamespace",
    "hasPID",
)
_DEFAULT_PARAM = "robot_description"


def plugin_findings(facts: RobotFacts, spawned: bool) -> Iterator[Finding]:
    """Yield what is wrong in the plugins for Gazebo."""
    yield from _two(facts)
    yield from _none(facts, spawned)
    for plugin in facts.plugins:
        yield from _file(plugin)
        if plugin.is_control:
            yield from _parameters(plugin, _CONTROL)
        elif "roboticsgroup" in plugin.filename and plugin.is_mimic:
            yield from _parameters(plugin, _MIMIC)
            yield from _joints(plugin, facts)


def _description(plugin: PluginFacts) -> str:
    return (plugin.parameter("robotParam") or _DEFAULT_PARAM).strip("/")


def _two(facts: RobotFacts) -> Iterator[Finding]:
    first: dict[str, PluginFacts] = {}
    for plugin in facts.control_plugins:
        earlier = first.setdefault(_description(plugin), plugin)
        if earlier is plugin:
            continue
        where = (
            "made by the same line, of a macro that is called twice"
            if plugin.location == earlier.location
            else f"at {earlier.location}"
        )
        yield error_at(
            plugin.location,
            "two-plugins",
            plugin.name,
            f"a second {LIBRARY}, '{short(plugin.name)}'; the first, "
            f"'{short(earlier.name)}', is {where}. Each makes a "
            "controller manager for every joint of the robot: their commands "
            "fight over the joints, and in one namespace the services of one "
            "hide those of the other",
            "keep one; an arm's and a gripper's macro often bring one each: "
            "remove the gripper's",
        )


def _none(facts: RobotFacts, spawned: bool) -> Iterator[Finding]:
    if not facts.transmissions or not (spawned or facts.plugins):
        return
    if any(plugin.is_control or plugin.is_control_of_ros2 for plugin in facts.plugins):
        return
    yield warning_at(
        facts.transmissions[0].location,
        "no-plugin",
        facts.name,
        f"the robot has transmissions, yet no {LIBRARY}: in Gazebo there is no "
        "controller manager, spawners wait for it in vain and the arm falls",
        f'add <gazebo><plugin name="ros_control" filename="{LIBRARY}"/></gazebo>',
    )


def _file(plugin: PluginFacts) -> Iterator[Finding]:
    if not plugin.filename:
        yield error_at(
            plugin.location,
            "unnamed",
            "<plugin>",
            "this <plugin> names no file, so Gazebo loads nothing",
            f'write filename="…", such as filename="{LIBRARY}"',
        )
    elif plugin.is_control_of_ros2 or plugin.filename.rpartition("/")[2] in _FILES:
        return
    elif plugin.is_control or nearest_name(plugin.filename, (LIBRARY,), cutoff=0.9):
        yield _misspelt(plugin)


def _misspelt(plugin: PluginFacts) -> Finding:
    return error_at(
        plugin.location,
        "unknown-plugin",
        plugin.name,
        f"there is no plugin '{short(plugin.filename)}', so Gazebo has no "
        "controller manager",
        f'write filename="{LIBRARY}"',
    )


def _parameters(plugin: PluginFacts, known: tuple[str, ...]) -> Iterator[Finding]:
    for name, _, location in plugin.parameters:
        if name in known:
            continue
        close = nearest_name(name, known)
        finding_at = error_at if close else warning_at
        yield finding_at(
            location,
            "unread-parameter",
            name,
            f"the plugin {short(plugin.filename)} does not read "
            f"<{short(name)}>, so it does nothing",
            f"write <{close}>" if close else f"it reads {quoted(known)}",
        )


def _joints(plugin: PluginFacts, facts: RobotFacts) -> Iterator[Finding]:
    places = {name: location for name, _, location in plugin.parameters}
    for role in ("joint", "mimicJoint"):
        name = plugin.parameter(role)
        if name and name in facts.joints:
            continue
        close = nearest_name(name or "", facts.joints)
        yield error_at(
            places.get(role, plugin.location),
            "unknown-joint",
            name or plugin.name,
            f"plugin '{short(plugin.name)}' has the <{role}> '{short(name or '')}'"
            ", which the robot lacks: it does nothing, and the finger hangs loose",
            f"write <{role}>{close}</{role}>"
            if close
            else "name one of the robot's joints",
        )


def extension_findings(root: Element, facts: RobotFacts) -> Iterator[Finding]:
    """Yield the extensions that refer to nothing."""
    known = {**facts.links, **facts.joints}
    for element in children(root, "gazebo"):
        name = attribute(element, "reference")
        if name and name not in known:
            close = nearest_name(name, known)
            yield warning_at(
                place(element),
                "unknown-reference",
                name,
                f'<gazebo reference="{short(name)}"> is about neither a link nor '
                "a joint of the robot, so it does nothing",
                f'write reference="{close}"' if close else "remove it",
            )
    yield from _gearboxes(facts)


def _gearboxes(facts: RobotFacts) -> Iterator[Finding]:
    body = bodies(facts)
    for gearbox in facts.gearboxes:
        for role, name in (("parent", gearbox.parent), ("child", gearbox.child)):
            if name in facts.links:
                merged = body[name]
                if merged == name:
                    continue
                reason = f"Gazebo has merged into '{short(merged)}'"
                remedy = f"write <{role}>{merged}</{role}>"
            else:
                close = nearest_name(name, facts.links)
                reason = "the robot lacks"
                remedy = (
                    f"write <{role}>{close}</{role}>"
                    if close
                    else "name one of its links"
                )
            yield error_at(
                gearbox.location,
                "unknown-link",
                gearbox.name,
                f"gearbox '{short(gearbox.name)}' has the {role} '{short(name)}', "
                f"which {reason}: Gazebo does not make the gearbox, and the "
                "finger hangs loose",
                remedy,
            )
