"""Parameters of controllers: joints, and PID gains with their control law."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from tool0.description.model import Interface, Joint, JointType
from tool0.description.yaml_tree import YamlEntry
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean, nearest_name


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """PID gains of one joint: ``p e + clamp(i ∫e dt) + d de/dt``.

    ``e`` is the position error [rad | m]; the command of an effort controller is an
    effort [N·m | N].  As in control_toolbox, an integral without a clamp contributes
    nothing.
    """

    p: float
    """Command per position error [N·m/rad | N/m]."""
    i: float = 0.0
    """Command per position error and second [N·m/(rad·s) | N/(m·s)]."""
    d: float = 0.0
    """Command per velocity error [N·m·s/rad | N·s/m]."""
    i_min: float = 0.0
    """Least contribution of the integral, at most 0 [N·m | N]."""
    i_max: float = 0.0
    """Greatest contribution of the integral, at least 0 [N·m | N]."""
    antiwindup: bool = False
    """Clamp the integral itself, not only its contribution."""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.p, self.i, self.d))):
            raise ConfigError(f"gains must be finite numbers, got {self}")
        if not self.i_min <= 0.0 <= self.i_max:
            raise ConfigError(f"need i_min <= 0 <= i_max, got {self}")


@final
class Pid:
    """Per joint: ``p e + clamp(i ∫e dt) + d de/dt``; no filter, no output clamp.

    A period of zero returns 0 and keeps the integral.  The errors must be finite, which
    the engine (DivergenceError) and the checks of goals and commands ensure.
    """

    __slots__ = ("integrals", "rows")

    def __init__(self, gains: Sequence[Gains]) -> None:
        self.rows = tuple(_row(k, g) for k, g in enumerate(gains))
        """For each joint its number, p, i, d, i_min, i_max, and whether antiwindup."""
        self.integrals = [0.0] * len(self.rows)
        """Of the errors, by joint."""

    def reset(self, joint: int) -> None:
        """Reset the integral of one joint, by its number."""
        self.integrals[joint] = 0.0

    def set_gains(self, k: int, gains: Gains) -> None:
        """Change the gains of joint ``k``.

        The contribution of the integral stays, within the new clamp, so that a new
        ``i`` causes no jump; without ``i`` the integral is reset.
        """
        _, _, i, _, i_min, i_max, _ = self.rows[k]
        term = min(max(i * self.integrals[k], i_min), i_max)
        term = min(max(term, gains.i_min), gains.i_max)
        self.integrals[k] = term / gains.i if gains.i else 0.0
        self.rows = (*self.rows[:k], _row(k, gains), *self.rows[k + 1 :])

    def update(
        self, errors: Sequence[float], error_rates: Sequence[float], period: float
    ) -> list[float]:
        """Return a command per joint."""
        if not period > 0.0:
            return [0.0] * len(self.rows)
        integrals = self.integrals
        commands: list[float] = []
        for k, p, i, d, i_min, i_max, antiwindup in self.rows:
            error = errors[k]
            integrals[k] = integral = integrals[k] + period * error
            term = i * integral
            if term > i_max:
                term = i_max
                if antiwindup:
                    integrals[k] = term / i
            elif term < i_min:
                term = i_min
                if antiwindup:
                    integrals[k] = term / i
            commands.append(p * error + term + d * error_rates[k])
        return commands


def _row(k: int, gains: Gains) -> tuple[int, float, float, float, float, float, bool]:
    g = gains
    return k, g.p, g.i, g.d, g.i_min, g.i_max, g.antiwindup


INTERFACE_OF_PACKAGE = {
    "effort_controllers": Interface.EFFORT,
    "position_controllers": Interface.POSITION,
    "velocity_controllers": Interface.VELOCITY,
}
"""The command interface that a controller type's package stands for."""


@final
@dataclass(frozen=True, slots=True)
class RobotJoints:
    """The joints that a controller's parameters may name."""

    joints: Mapping[str, Joint]
    interfaces: Mapping[str, Interface]
    """The joints with a transmission, in the engine's order."""

    @staticmethod
    def assumed(names: Iterable[str], type_name: str) -> RobotJoints:
        """Return joints that a controller of this type can command, without a robot."""
        package = type_name.partition("/")[0]
        interface = INTERFACE_OF_PACKAGE.get(package, Interface.EFFORT)
        joints = {
            name: Joint(
                name=name, type=JointType.CONTINUOUS, parent="world", child=name
            )
            for name in names
        }
        return RobotJoints(joints, dict.fromkeys(joints, interface))


def joint_entries(controller: YamlEntry) -> list[YamlEntry]:
    """Return where a controller names its joints: ``joint`` and those of ``joints``."""
    joint, joints = controller.find("joint"), controller.find("joints")
    return [
        *([] if joint is None else [joint]),
        *([] if joints is None else joints.items),
    ]


def controlled_joint(
    robot: RobotJoints, name: str, interface: Interface | None, entry: YamlEntry
) -> Joint:
    """Return the joint called ``name``, if it takes ``interface``; None is any.

    ``entry`` is its place in the file, for messages.
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
    if interface is not None and has is not interface:
        raise ConfigError(
            f"Could not find joint '{name}' in {wanted}: "
            f"its <transmission> offers '{has.value}'",
            entry.location,
        )
    return joint


def controlled_joints(
    robot: RobotJoints, parameters: Namespace, interface: Interface
) -> tuple[Joint, ...]:
    """Return the joints of the list ``joints``, each of them named once."""
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
    """Return the joint that ``joint`` names."""
    name = parameters.text("joint")
    entry = parameters.find("joint") or parameters.entry
    return controlled_joint(robot, name, interface, entry)


def read_gains(parameters: Namespace, path: str, why: str) -> Gains:
    """Return the gains at ``path``; ``p`` is required, as in control_toolbox.

    ``why`` is the reason for the message if they are missing.
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
