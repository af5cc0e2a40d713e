"""Choice of the controllers in a YAML file that can drive a robot unambiguously."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from tool0.control.config import ControllerConfig
from tool0.control.controller import ControllerSpec
from tool0.control.parameters import RobotJoints
from tool0.description.finding import quoted
from tool0.errors import ConfigError
from tool0.protocol.controllers import Role

_GOALS = (Role.TRAJECTORY, Role.GRIPPER)
_STATES = ("JointStateController", "JointStateBroadcaster")
_SCALED = "Scaled"
"""Part of the type names of Universal Robots' trajectory controllers that scale their
speed."""


class Choice(NamedTuple):
    """The additional controllers to start, and the reasons for not starting others."""

    started: tuple[str, ...]
    reasons: tuple[str, ...]


def choose(
    config: ControllerConfig,
    robot: RobotJoints,
    usual: Sequence[str],
    not_to_start: Collection[str],
) -> Choice:
    """Return the controllers in a YAML file that can be started unambiguously.

    Controllers that follow goals take precedence: such a controller is started if no
    other controller that follows goals drives any of its joints.  A controller without
    goals is started if no other controller drives any of its joints.

    Args:
        config: The content of the YAML file.
        robot: The joints and their command interfaces.
        usual: Names of the controllers that are started in any case.
        not_to_start: Names of controllers that are not considered.
    """
    specs: dict[str, ControllerSpec] = {}
    failed: dict[str, str] = {}
    reasons = []
    for name in config.names:
        if name in not_to_start:
            continue
        try:
            specs[name] = config.spec(name, robot)
        except ConfigError as error:
            failed[name] = str(error)
    taken = {
        joint
        for name in usual
        if name in specs and specs[name].interface is not None
        for joint in specs[name].joints
    }
    fitting = {
        name: spec
        for name, spec in specs.items()
        if name not in usual
        and spec.joints
        and spec.interface is not None
        and all(spec.interface in robot.interfaces.get(j, ()) for j in spec.joints)
        and not taken.intersection(spec.joints)
    }
    started = [
        name
        for name in specs
        if name not in usual and config.types[name].endswith(_STATES)
    ]
    driven = set(taken)
    for roles in (_GOALS, (Role.COMMAND,)):
        rivals: Mapping[str, ControllerSpec] = {
            name: spec
            for name, spec in fitting.items()
            if config.dialect.role(config.types[name]) in roles
            and not taken.intersection(spec.joints)
        }
        rivals = _without_scaled(config, rivals)
        for name, spec in rivals.items():
            others = [n for n, s in rivals.items() if set(s.joints) & set(spec.joints)]
            if others == [name]:
                started.append(name)
                driven.update(spec.joints)
            elif others[0] == name:
                joint = next(j for j in spec.joints if j in rivals[others[1]].joints)
                reasons.append(
                    f"{quoted(others)} all drive '{joint}', and none is started"
                )
        taken.update(joint for spec in rivals.values() for joint in spec.joints)
    for name, why in failed.items():
        is_needed = not driven.issuperset(_joints(config, robot, name))
        if name not in usual and is_needed and _is_of_goals(config, name):
            reasons.append(f"'{name}' cannot be started: {why}")
    return Choice(tuple(started), tuple(reasons))


def _joints(config: ControllerConfig, robot: RobotJoints, name: str) -> set[str]:
    """Return the joints that a controller lists, even if its parameters are invalid."""
    values = config.parameters_of(name, robot).values
    joints = values.get("joints", ())
    return {str(values.get("joint", ""))} - {""} | set(
        map(str, joints) if isinstance(joints, tuple) else ()
    )


def _is_of_goals(config: ControllerConfig, name: str) -> bool:
    return config.dialect.role(config.types[name]) in _GOALS


def _without_scaled(
    config: ControllerConfig, rivals: Mapping[str, ControllerSpec]
) -> Mapping[str, ControllerSpec]:
    """Omit scaled controllers if an unscaled controller can also drive their joints."""
    plain = {
        joint
        for name, spec in rivals.items()
        if _SCALED not in config.types[name]
        for joint in spec.joints
    }
    return {
        name: spec
        for name, spec in rivals.items()
        if _SCALED not in config.types[name] or not plain.intersection(spec.joints)
    }
