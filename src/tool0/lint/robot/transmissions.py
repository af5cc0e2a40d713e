"""Finds transmissions that ros_control skips, reads wrongly or rejects."""

from __future__ import annotations

from collections.abc import Iterator

from tool0.description.finding import Finding, quoted, short
from tool0.description.model import Interface
from tool0.errors import nearest_name
from tool0.lint.robot.elements import Subject, suggestion
from tool0.lint.robot.facts import (
    InterfaceFacts,
    Robot,
    RobotFacts,
    TransmissionFacts,
    is_interface,
)

SIMPLE = "transmission_interface/SimpleTransmission"
_OTHERS = (
    "transmission_interface/DifferentialTransmission",
    "transmission_interface/FourBarLinkageTransmission",
)
_DEFAULT_SIMULATOR = "gazebo_ros_control/DefaultRobotHWSim"
_VALID = ", ".join(item.value for item in Interface)


def transmission_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the faults of the ROS 1 transmissions."""
    first: dict[str, TransmissionFacts] = {}
    for transmission in robot.facts.transmissions:
        yield from _incomplete(transmission)
        yield from _type(transmission)
        for name in transmission.joints:
            yield from _joint(transmission, name, robot.facts, first)
        named = _counting(transmission)
        if len(named) > 1 and len(transmission.joints) == 1:
            yield named[1].at.warning(
                "two-interfaces",
                f"{_shown(transmission)} names {len(named)} interfaces; Gazebo takes "
                f"the first, '{short(named[0].written)}', and controllers of the "
                "others do not load",
                "keep the one that the controller is made for",
                key=transmission.at.key,
            )
    yield from _unknown_interfaces(robot.facts)
    if robot.is_controlled:
        yield from _undriven(robot.facts)


def _shown(transmission: TransmissionFacts) -> str:
    return f"transmission '{short(transmission.at.key)}'"


def _incomplete(transmission: TransmissionFacts) -> Iterator[Finding]:
    lacking = {
        'name="…"': bool(transmission.at.key),
        f"<type>{SIMPLE}</type>": bool(transmission.type),
        '<joint name="…">': bool(transmission.joints),
        f"<hardwareInterface>{Interface.EFFORT.value}</hardwareInterface> "
        "in its <joint>": any(not item.in_actuator for item in transmission.interfaces),
        '<actuator name="…"/>': bool(transmission.n_actuators),
    }
    missing = [what for what, is_there in lacking.items() if not is_there]
    if missing:
        yield transmission.at.error(
            "incomplete-transmission",
            f"{_shown(transmission)} is not complete, so ros_control skips it and "
            f"no controller finds the joint {quoted(transmission.joints)}",
            f"add {', '.join(missing)}",
        )
    if len(transmission.joints) > 1 and transmission.type == SIMPLE:
        yield transmission.at.error(
            "incomplete-transmission",
            f"{_shown(transmission)} has {len(transmission.joints)} joints, so "
            "gazebo_ros_control skips it and no controller finds them",
            "write one <transmission> for each joint",
        )


def _type(transmission: TransmissionFacts) -> Iterator[Finding]:
    if not transmission.type or transmission.type == SIMPLE:
        return
    known = {name.rpartition("/")[2]: name for name in (SIMPLE, *_OTHERS)}
    # A robot may define the name HalfDifferentialTransmission, whose similarity to a
    # name of ros_control is 0.92.
    close = nearest_name(transmission.type.rpartition("/")[2], known, cutoff=0.93)
    has_type = f"{_shown(transmission)} has the type '{short(transmission.type)}'"
    if close is not None and transmission.type not in _OTHERS:
        yield transmission.at.error(
            "unknown-transmission",
            f"{has_type}, which is misspelt: a real robot's driver refuses it",
            f"write <type>{known[close]}</type>",
        )
    else:
        yield transmission.at.warning(
            "unknown-transmission",
            f"{has_type}, which gazebo_ros_control does not simulate: it drives one "
            "joint alone, and skips a transmission of several",
            f"for Gazebo write <type>{SIMPLE}</type>, once for each joint",
        )


def _joint(
    transmission: TransmissionFacts,
    name: str,
    facts: RobotFacts,
    first: dict[str, TransmissionFacts],
) -> Iterator[Finding]:
    joint = facts.joints.get(name)
    earlier = first.setdefault(name, transmission)
    at = Subject(name, transmission.at.location)
    if joint is None:
        movable = facts.movable_joints
        yield at.error(
            "unknown-joint",
            f"{_shown(transmission)} drives the joint '{short(name)}', which the robot "
            "lacks: gazebo_ros_control stops at it, and no controller runs",
            suggestion(
                name,
                movable,
                'write <joint name="{}">',
                f"the joints that move are {quoted(movable)}",
            ),
        )
    elif earlier is not transmission:
        yield at.error(
            "two-transmissions",
            f"joint '{short(name)}' has two transmissions, "
            f"'{short(earlier.at.key)}' at {earlier.at.location} and "
            f"'{short(transmission.at.key)}', so it is registered twice and "
            "one interface hides the other",
            "remove one of them",
        )
    elif joint.mimic_of is not None:
        yield at.warning(
            "driven-mimic",
            f"joint '{short(name)}' mimics '{short(joint.mimic_of)}' and has a "
            "transmission too: ros_control drives it independently, against its "
            "coupling",
            "remove the transmission, or the <mimic>",
        )
    elif joint.type == "fixed":
        yield at.error(
            "unknown-joint",
            f"{_shown(transmission)} drives '{short(name)}', which is fixed: "
            "Gazebo has merged it away, and gazebo_ros_control stops",
            "remove the transmission, or let the joint move",
        )


def _counting(transmission: TransmissionFacts) -> tuple[InterfaceFacts, ...]:
    """Return the interfaces that ROS reads.

    Interfaces in <actuator> are read only if there are no other interfaces.
    """
    named = tuple(item for item in transmission.interfaces if not item.in_actuator)
    return named or transmission.interfaces


def _unknown_interfaces(facts: RobotFacts) -> Iterator[Finding]:
    """Yield the interfaces that ROS does not have, once for each place in a macro."""
    simulators = {plugin.parameter("robotSimType") for plugin in facts.control_plugins}
    found: dict[Subject, tuple[str | None, list[str]]] = {}
    for transmission in facts.transmissions:
        for interface in _counting(transmission):
            if not is_interface(interface.written):
                joints = found.setdefault(interface.at, (interface.meant, []))[1]
                joints.extend(transmission.joints)
    for at, (meant, joints) in found.items():
        has_quotes = at.key.strip("\"'") != at.key
        if meant:
            yield at.error(
                "interface-typo",
                f"there is no hardware interface '{short(at.key)}'"
                + (" (the quotation marks are part of it)" * has_quotes)
                + f": gazebo_ros_control stops at joint {quoted(joints)}, and no "
                "controller runs",
                f"write {meant}",
            )
        elif simulators <= {None, _DEFAULT_SIMULATOR}:
            yield at.warning(
                "unknown-interface",
                f"gazebo_ros_control stops at the interface "
                f"'{short(at.key)}' of {quoted(joints)}; only a "
                "robot's own driver may know it",
                f"for Gazebo write one of {_VALID}",
            )


def _undriven(facts: RobotFacts) -> Iterator[Finding]:
    driven = {text for plugin in facts.plugins for _, text in plugin.parameters}
    driven |= facts.driven_joints
    for joint in facts.joints.values():
        is_caster = joint.type == "continuous" and not joint.has_limits
        if joint.is_drivable and not is_caster and joint.name not in driven:
            yield joint.at.warning(
                "no-transmission",
                f"joint '{short(joint.name)}' moves, yet has no transmission: no "
                "controller can drive it, it hangs loose and is not in "
                "/joint_states",
                f"write a <transmission> of {SIMPLE} with "
                f'<joint name="{short(joint.name)}"> and a <hardwareInterface>, '
                "or make the joint fixed",
            )
