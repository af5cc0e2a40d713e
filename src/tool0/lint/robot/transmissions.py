"""Transmissions that ros_control skips, misreads, or stops at."""

from __future__ import annotations

from collections.abc import Iterator

from tool0.description.finding import Finding, error_at, quoted, short, warning_at
from tool0.description.model import Interface
from tool0.errors import SourceLocation, nearest_name
from tool0.lint.robot.facts import RobotFacts, TransmissionFacts
from tool0.lint.robot.interfaces import InterfaceFacts

SIMPLE = "transmission_interface/SimpleTransmission"
_OTHERS = (
    "transmission_interface/DifferentialTransmission",
    "transmission_interface/FourBarLinkageTransmission",
)
_DEFAULT_SIMULATOR = "gazebo_ros_control/DefaultRobotHWSim"
_VALID = ", ".join(item.value for item in Interface)


def transmission_findings(facts: RobotFacts, spawned: bool) -> Iterator[Finding]:
    """Yield what is wrong in the transmissions of ROS 1."""
    first: dict[str, TransmissionFacts] = {}
    for transmission in facts.transmissions:
        yield from _incomplete(transmission)
        yield from _type(transmission)
        yield from _joints(transmission, facts, first)
        yield from _interfaces(transmission)
    yield from _unknown_interfaces(facts)
    if facts.transmissions or facts.control_plugins or spawned:
        yield from _undriven(facts)


def _said(transmission: TransmissionFacts) -> str:
    return f"transmission '{short(transmission.name)}'"


def _incomplete(transmission: TransmissionFacts) -> Iterator[Finding]:
    simple = f"<type>{SIMPLE}</type>"
    lacking = {
        'name="…"': bool(transmission.name),
        simple: bool(transmission.type),
        '<joint name="…">': bool(transmission.joints),
        f"<hardwareInterface>{Interface.EFFORT.value}</hardwareInterface> "
        "in its <joint>": any(not item.in_actuator for item in transmission.interfaces),
        '<actuator name="…"/>': bool(transmission.n_actuators),
    }
    missing = [what for what, is_there in lacking.items() if not is_there]
    if missing:
        yield error_at(
            transmission.location,
            "incomplete-transmission",
            transmission.name,
            f"{_said(transmission)} is not complete, so ros_control skips it and "
            f"no controller finds the joint {quoted(transmission.joints)}",
            f"add {', '.join(missing)}",
        )


def _type(transmission: TransmissionFacts) -> Iterator[Finding]:
    if not transmission.type or transmission.type == SIMPLE:
        return
    known = {name.rpartition("/")[2]: name for name in (SIMPLE, *_OTHERS)}
    # HalfDifferentialTransmission, a robot's own, is 0.92 like the nearest of these.
    close = nearest_name(transmission.type.rpartition("/")[2], known, cutoff=0.93)
    is_typo = close is not None and transmission.type not in _OTHERS
    finding_at = error_at if is_typo else warning_at
    yield finding_at(
        transmission.location,
        "unknown-transmission",
        transmission.name,
        f"{_said(transmission)} has the type '{short(transmission.type)}'"
        + (
            ", which is misspelt: a real robot's driver refuses it"
            if is_typo
            else ", which gazebo_ros_control does not simulate: it drives one "
            "joint by itself, and skips a transmission of several"
        ),
        f"write <type>{known[close]}</type>"
        if close and is_typo
        else f"for Gazebo write <type>{SIMPLE}</type>, once for each joint",
    )


def _joints(
    transmission: TransmissionFacts,
    facts: RobotFacts,
    first: dict[str, TransmissionFacts],
) -> Iterator[Finding]:
    if len(transmission.joints) > 1 and transmission.type == SIMPLE:
        yield error_at(
            transmission.location,
            "incomplete-transmission",
            transmission.name,
            f"{_said(transmission)} has {len(transmission.joints)} joints, so "
            "gazebo_ros_control skips it and no controller finds them",
            "write one <transmission> for each joint",
        )
    for name in transmission.joints:
        joint = facts.joints.get(name)
        earlier = first.setdefault(name, transmission)
        if joint is None:
            yield _unknown(transmission, name, facts)
        elif earlier is not transmission:
            yield error_at(
                transmission.location,
                "two-transmissions",
                name,
                f"joint '{short(name)}' has two transmissions, "
                f"'{short(earlier.name)}' at {earlier.location} and "
                f"'{short(transmission.name)}', so it is registered twice and "
                "one interface hides the other",
                "remove one of them",
            )
        elif joint.mimic_of is not None:
            yield warning_at(
                transmission.location,
                "driven-mimic",
                name,
                f"joint '{short(name)}' mimics '{short(joint.mimic_of)}' and has a "
                "transmission too: ros_control drives it by itself, against what "
                "makes it follow",
                "remove the transmission, or the <mimic>",
            )
        elif joint.type == "fixed":
            yield error_at(
                transmission.location,
                "unknown-joint",
                name,
                f"{_said(transmission)} drives '{short(name)}', which is fixed: "
                "Gazebo has merged it away, and gazebo_ros_control stops",
                "remove the transmission, or let the joint move",
            )


def _unknown(transmission: TransmissionFacts, name: str, facts: RobotFacts) -> Finding:
    movable = [joint.name for joint in facts.joints.values() if joint.is_movable]
    close = nearest_name(name, movable)
    return error_at(
        transmission.location,
        "unknown-joint",
        name,
        f"{_said(transmission)} drives the joint '{short(name)}', which the robot "
        "lacks: gazebo_ros_control stops at it, and no controller runs",
        f'write <joint name="{close}">'
        if close
        else f"the joints that move are {quoted(movable)}",
    )


def _counting(transmission: TransmissionFacts) -> tuple[InterfaceFacts, ...]:
    """Return the interfaces that are read: those in <actuator> only if alone."""
    named = tuple(item for item in transmission.interfaces if not item.in_actuator)
    return named or transmission.interfaces


def _interfaces(transmission: TransmissionFacts) -> Iterator[Finding]:
    named = _counting(transmission)
    if len(named) > 1 and len(transmission.joints) == 1:
        kept = short(named[0].written)
        yield warning_at(
            named[1].location,
            "two-interfaces",
            transmission.name,
            f"{_said(transmission)} names {len(named)} interfaces; Gazebo takes "
            f"the first, '{kept}', and controllers of the others do not load",
            "keep the one that the controller is made for",
        )


def _unknown_interfaces(facts: RobotFacts) -> Iterator[Finding]:
    """Yield the interfaces that ROS does not know, each place in a macro once."""
    simulators = {plugin.parameter("robotSimType") for plugin in facts.control_plugins}
    found: dict[tuple[SourceLocation, str], tuple[InterfaceFacts, list[str]]] = {}
    for transmission in facts.transmissions:
        for interface in _counting(transmission):
            if not interface.is_known:
                key = (interface.location, interface.written)
                found.setdefault(key, (interface, []))[1].extend(transmission.joints)
    for interface, joints in found.values():
        if interface.meant:
            yield _typo(interface, joints)
        elif simulators <= {None, _DEFAULT_SIMULATOR}:
            yield warning_at(
                interface.location,
                "unknown-interface",
                interface.written,
                f"gazebo_ros_control stops at the interface "
                f"'{short(interface.written)}' of {quoted(joints)}; only a "
                "robot's own driver may know it",
                f"for Gazebo write one of {_VALID}",
            )


def _typo(interface: InterfaceFacts, joints: list[str]) -> Finding:
    quotes = interface.written.strip("\"'") != interface.written
    return error_at(
        interface.location,
        "interface-typo",
        interface.written,
        f"there is no hardware interface '{short(interface.written)}'"
        + (" (its quotation marks count)" * quotes)
        + f": gazebo_ros_control stops at joint {quoted(joints)}, and no "
        "controller runs",
        f"write {interface.meant}",
    )


def _undriven(facts: RobotFacts) -> Iterator[Finding]:
    driven = facts.driven_joints | facts.plugin_joints
    for joint in facts.joints.values():
        is_caster = joint.type == "continuous" and joint.limits is None
        if joint.is_drivable and not is_caster and joint.name not in driven:
            yield warning_at(
                joint.location,
                "no-transmission",
                joint.name,
                f"joint '{short(joint.name)}' moves, yet has no transmission: no "
                "controller can drive it, it hangs loose and is not in "
                "/joint_states",
                f"write a <transmission> of {SIMPLE} with "
                f'<joint name="{short(joint.name)}"> and a <hardwareInterface>, '
                "or make the joint fixed",
            )
