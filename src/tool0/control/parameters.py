"""Parameters of controllers: joints, and PID gains with their control law."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

from tool0.control.tolerances import (
    DEFAULT_GOAL_TOLERANCE,
    DEFAULT_SLIDING_TOLERANCE,
    DEFAULT_STOPPED_VELOCITY,
    JointTolerances,
)
from tool0.description.finding import quoted
from tool0.description.hardware_component import HardwareComponent
from tool0.description.model import Interface, Joint, JointType, ParallelGripper
from tool0.description.yaml_tree import YamlEntry
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean, nearest_name
from tool0.protocol.controllers import Gains, Unwinding
from tool0.protocol.goals import Tolerance


@final
class Pid:
    """PID law per joint: ``p e + clamp(i ∫e dt) + d de/dt``, without a filter.

    The command is limited.

    If the period is 0, the command is 0 and the integral is unchanged.  The errors must
    be finite, which the engine (DivergenceError) and the checks of goals and commands
    ensure.
    """

    __slots__ = ("integrals", "rows")

    def __init__(self, gains: Sequence[Gains]) -> None:
        self.rows = tuple(_row(k, g) for k, g in enumerate(gains))
        """Index and gains of each joint."""
        self.integrals = [0.0] * len(self.rows)
        """Integral of each joint's error."""

    def reset(self, joint: int) -> None:
        """Reset the integral of one joint, which is given by its index."""
        self.integrals[joint] = 0.0

    def set_contribution(self, joint: int, command: float) -> None:
        """Make a joint's integral contribute ``command``, within the clamp."""
        _, _, i, _, i_min, i_max, *_ = self.rows[joint]
        term = min(max(command, i_min), i_max)
        self.integrals[joint] = term / i if i else 0.0

    def set_gains(self, k: int, gains: Gains) -> None:
        """Change the gains of joint ``k``.

        The contribution of the integral is kept, within the new clamp, so that a new
        ``i`` causes no jump.  If ``i`` is 0, the integral is reset.
        """
        _, _, i, _, i_min, i_max, *_ = self.rows[k]
        term = min(max(i * self.integrals[k], i_min), i_max)
        term = min(max(term, gains.i_min), gains.i_max)
        self.integrals[k] = term / gains.i if gains.i else 0.0
        self.rows = (*self.rows[:k], _row(k, gains), *self.rows[k + 1 :])

    def update(
        self, errors: Sequence[float], error_rates: Sequence[float], period: float
    ) -> list[float]:
        """Return one command per joint."""
        if not period > 0.0:
            return [0.0] * len(self.rows)
        integrals = self.integrals
        commands: list[float] = []
        for row in self.rows:
            k, p, i, d, i_min, i_max, antiwindup, u_min, u_max, deadband, *_ = row
            error = errors[k]
            if not -deadband <= error <= deadband:
                integrals[k] += period * error
            term = i * integrals[k]
            if term > i_max:
                term = i_max
                if antiwindup:
                    integrals[k] = term / i
            elif term < i_min:
                term = i_min
                if antiwindup:
                    integrals[k] = term / i
            command = p * error + term + d * error_rates[k]
            if not u_min <= command <= u_max:
                command = self._limited(row, error, command, period)
            commands.append(command)
        return commands

    def _limited(
        self, row: PidRow, error: float, command: float, period: float
    ) -> float:
        """Return a command within the limits, and unwind the integral."""
        k, _, i, *_, u_min, u_max, _, unwinding, tracking_time = row
        limited = u_max if command > u_max else u_min
        if unwinding == _CONDITIONAL and error * command > 0.0:
            self.integrals[k] -= period * error
        elif unwinding == _BACK_CALCULATION and i != 0.0:
            excess = limited - command
            self.integrals[k] += period * excess / (tracking_time * i)
        return limited


PidRow = tuple[
    int, float, float, float, float, float, bool, float, float, float, int, float
]
"""A joint's index and its gains, in the order of ``Gains``."""
_CONDITIONAL = Unwinding.CONDITIONAL_INTEGRATION.value
_BACK_CALCULATION = Unwinding.BACK_CALCULATION.value


def _row(k: int, gains: Gains) -> PidRow:
    g = gains
    limits = g.u_min, g.u_max, g.error_deadband, g.unwinding.value, g.tracking_time
    return k, g.p, g.i, g.d, g.i_min, g.i_max, g.antiwindup, *limits


INTERFACE_OF_PACKAGE = {
    "effort_controllers": Interface.EFFORT,
    "position_controllers": Interface.POSITION,
    "velocity_controllers": Interface.VELOCITY,
}
"""Command interface that is implied by the package of a controller's type."""
INTERFACE_OF_NAME = {item.name.lower(): item for item in Interface}
"""Command interfaces, by their names in ROS 2."""
JOINT_STATES = ("position", "velocity", "effort")
"""State interfaces of a driven joint."""


@final
@dataclass(frozen=True, slots=True)
class RobotJoints:
    """The joints that controllers' parameters can specify, and the robot's hardware."""

    joints: Mapping[str, Joint]
    interfaces: Mapping[str, tuple[Interface, ...]]
    """Driven joints, in the order of the engine, with their command interfaces."""
    hardware: tuple[HardwareComponent, ...] = ()
    """Hardware that ``<ros2_control>`` tags describe."""
    grippers: tuple[ParallelGripper, ...] = ()
    speed_scaling: Mapping[str, float] = field(default_factory=dict)
    """Prefix of each arm → current speed factor of its trajectories."""
    arms: Mapping[str, tuple[str, ...]] | None = field(default_factory=dict)
    """Prefix of each arm → its joints, from the base to the flange; None if any prefix
    is accepted."""
    gripper_delay: float = 0.0
    """Longest time until a command to a gripper affects its state [s]."""

    @property
    def joint_states(self) -> tuple[str, ...]:
        """The state interfaces of joints, with their names in ROS 2."""
        if not self.hardware:
            return tuple(
                f"{j}/{kind}" for j in self.interfaces for kind in JOINT_STATES
            )
        return tuple(
            f"{joint.name}/{state.name}"
            for component in self.hardware
            for joint in component.joints
            for state in joint.states
        )

    @staticmethod
    def assumed(names: Iterable[str], type_name: str) -> RobotJoints:
        """Return artificial joints that a controller of a given type can command."""
        package = type_name.partition("/")[0]
        known = INTERFACE_OF_PACKAGE.get(package)
        interfaces = tuple(Interface) if known is None else (known,)
        joints = {
            name: Joint(
                name=name, type=JointType.CONTINUOUS, parent="world", child=name
            )
            for name in names
        }
        return RobotJoints(joints, dict.fromkeys(joints, interfaces), arms=None)


def joint_entries(controller: YamlEntry) -> list[YamlEntry]:
    """Return the entries that list a controller's joints: ``joint`` and ``joints``."""
    joint, joints = controller.find("joint"), controller.find("joints")
    return [
        *([] if joint is None else [joint]),
        *([] if joints is None else joints.items),
    ]


def controlled_joint(
    robot: RobotJoints, name: str, interface: Interface | None, entry: YamlEntry
) -> Joint:
    """Return the joint ``name``; it must have ``interface`` if one is given.

    ``entry`` is the YAML entry that contains the name; messages report its location.
    """
    joint = robot.joints.get(name)
    wanted = "any interface" if interface is None else f"'{interface.value}'"
    if joint is None:
        raise ConfigError(
            f"Could not find joint '{name}' in {wanted}: the robot has no such joint"
            + did_you_mean(name, robot.interfaces),
            entry.location,
        )
    has = robot.interfaces.get(name)
    if has is None:
        why = f" and follows '{joint.mimic.joint}'" if joint.mimic is not None else ""
        raise ConfigError(
            f"Could not find joint '{name}' in {wanted}: it has no <transmission>{why}"
            f"; joints with one: {', '.join(robot.interfaces) or '(none)'}",
            entry.location,
        )
    if interface is not None and interface not in has:
        raise ConfigError(
            f"Could not find joint '{name}' in {wanted}: "
            f"its drive offers {quoted(item.value for item in has)}",
            entry.location,
        )
    return joint


def controlled_joints(
    robot: RobotJoints, parameters: Namespace, interface: Interface
) -> tuple[Joint, ...]:
    """Return the joints in the list ``joints``, which must not contain duplicates."""
    names = parameters.texts("joints")
    entry = parameters.find("joints")
    items = [] if entry is None else entry.items
    for name, item in zip(names, items, strict=True):
        if names.count(name) > 1:
            raise ConfigError(f"'{item.key}' names joint '{name}' twice", item.location)
    return tuple(
        controlled_joint(robot, name, interface, item)
        for name, item in zip(names, items, strict=True)
    )


def single_joint(
    robot: RobotJoints, parameters: Namespace, interface: Interface
) -> Joint:
    """Return the joint that the parameter ``joint`` specifies."""
    name = parameters.text("joint")
    entry = parameters.find("joint") or parameters.entry
    return controlled_joint(robot, name, interface, entry)


def read_tolerances(
    parameters: Namespace, joints: Sequence[Joint], robot: RobotJoints
) -> dict[str, JointTolerances]:
    """Return the tolerances of a trajectory controller's joints.

    A joint that drives a gripper has no default goal tolerance, since a held object
    prevents the joint from reaching its goal.
    """
    read = parameters.not_negative
    stopped = read("constraints/stopped_velocity_tolerance", DEFAULT_STOPPED_VELOCITY)
    grippers = {gripper.joint for gripper in robot.grippers}
    found = {}
    for joint in joints:
        is_sliding = joint.type is JointType.PRISMATIC
        default = DEFAULT_SLIDING_TOLERANCE if is_sliding else DEFAULT_GOAL_TOLERANCE
        default = 0.0 if joint.name in grippers else default
        found[joint.name] = JointTolerances(
            path=Tolerance(read(f"constraints/{joint.name}/trajectory", 0.0)),
            goal=Tolerance(read(f"constraints/{joint.name}/goal", default), stopped),
        )
    return found


def read_at_least(
    parameters: Namespace, path: str, default: float, least: float
) -> float:
    """Return the number at ``path``, or raise ConfigError if it is too small."""
    value = parameters.number(path, default)
    entry = parameters.find(path)
    if entry is not None and value < least:
        raise ConfigError(
            f"'{entry.key}' must be at least {least}, got {value}", entry.location
        )
    return value


def read_gains(parameters: Namespace, path: str, why: str) -> Gains:
    """Return the gains at ``path``.

    The gain ``p`` is required, as it is in control_toolbox.

    ``why`` is the reason in the error message if gains are missing.
    """
    gains = parameters.namespace(path)
    if gains is None:
        outer = parameters.find(path.rpartition("/")[0]) or parameters.entry
        near = nearest_name(path.rpartition("/")[2], outer.children)
        hint = f"; did you mean '{near}'?" if near else ""
        raise ConfigError(
            f"No p gain specified for pid: '{parameters.entry.key}' lacks "
            f"'{path}/p', which {why}" + hint,
            outer.location,
        )
    if gains.find("p") is None:
        raise ConfigError(
            f"No p gain specified for pid: '{gains.entry.key}' lacks 'p', which {why}",
            gains.location,
        )
    gains.accept("publish_state")
    clamp = abs(gains.number("i_clamp", 0.0))
    return Gains(
        p=gains.number("p"),
        i=gains.number("i", 0.0),
        d=gains.number("d", 0.0),
        i_min=-abs(gains.number("i_clamp_min", clamp)),
        i_max=abs(gains.number("i_clamp_max", clamp)),
        antiwindup=gains.boolean("antiwindup", default=False),
    )
