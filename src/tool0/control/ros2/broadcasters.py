"""State interfaces for the broadcasters of wrenches, poses and speed scaling."""

from __future__ import annotations

from collections.abc import Sequence

from tool0.control.parameters import RobotJoints
from tool0.control.passive import PassiveSpec
from tool0.description.hardware_component import AXES, WRENCH
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean

_POSE = (
    *(f"position.{axis}" for axis in AXES),
    *(f"orientation.{part}" for part in (*AXES, "w")),
)


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> PassiveSpec:
    """Return the checked parameters of a broadcaster."""
    match type_name.partition("/")[2]:
        case "ForceTorqueSensorBroadcaster":
            states = _force_torque(parameters, robot)
        case "ForceTorqueStateBroadcaster":
            states = _force_torque_of_ur(parameters, robot)
        case "PoseBroadcaster":
            states = _pose(parameters)
        case _:
            states = _speed_scaling(parameters)
    return PassiveSpec(name=name, type=type_name, state_interfaces=tuple(states))


def _force_torque(parameters: Namespace, robot: RobotJoints) -> Sequence[str]:
    """Read the parameters of the broadcaster in ros2_controllers."""
    _filled(parameters, "frame_id")
    sensor = parameters.text("sensor_name", "")
    named = []
    for kind in WRENCH:
        path = kind.replace(".", "/")
        named.append(parameters.text(f"interface_names/{path}", ""))
        for change, default in (("offset", 0.0), ("multiplier", 1.0)):
            parameters.number(f"{change}/{path}", default)
            parameters.mark_adjustable(f"{change}/{path}")
    # The YAML from Universal Robots contains the last two parameters, which only the
    # Universal Robots broadcaster reads.
    parameters.accept("sensor_filter_chain", "topic_name", "state_interface_names")
    states = [state for state in named if state]
    if bool(sensor) is bool(states):
        raise ConfigError(
            f"'{parameters.entry.key}' needs either 'sensor_name' or "
            "'interface_names.force.x' … 'interface_names.torque.z'",
            parameters.location,
        )
    if sensor:
        states = _of_sensor(parameters, robot, sensor, WRENCH)
    return states


def _force_torque_of_ur(parameters: Namespace, robot: RobotJoints) -> Sequence[str]:
    """Read the parameters of the Universal Robots broadcaster."""
    parameters.text("frame_id")
    parameters.text("topic_name")
    sensor = parameters.text("sensor_name")
    kinds = parameters.texts("state_interface_names")
    return _of_sensor(parameters, robot, sensor, kinds)


def _of_sensor(
    parameters: Namespace, robot: RobotJoints, sensor: str, kinds: Sequence[str]
) -> list[str]:
    """Return the state interfaces of a sensor; the hardware must provide them."""
    wanted = [f"{sensor}/{kind}" for kind in kinds]
    known = [state for item in robot.hardware for state in item.state_interfaces]
    missing = [state for state in wanted if state not in known]
    if robot.hardware and missing:
        entry = parameters.find("sensor_name") or parameters.entry
        sensors = {state.partition("/")[0] for state in known if "force" in state}
        hint = did_you_mean(sensor, sensors) if sensor not in sensors else ""
        raise ConfigError(
            f"'{entry.key}': the robot's <ros2_control> has no state interface "
            f"'{missing[0]}'{hint}",
            entry.location,
        )
    return wanted


def _pose(parameters: Namespace) -> Sequence[str]:
    _filled(parameters, "frame_id")
    pose = _filled(parameters, "pose_name")
    parameters.boolean("tf/enable", default=True)
    parameters.text("tf/child_frame_id", "")
    parameters.accept("tf_publish_rate", "tf/publish_rate")
    return [f"{pose}/{kind}" for kind in _POSE]


def _speed_scaling(parameters: Namespace) -> Sequence[str]:
    prefix = parameters.text("tf_prefix", "")
    parameters.number("state_publish_rate", 100.0)
    return [f"{prefix}speed_scaling/speed_scaling_factor"]


def _filled(parameters: Namespace, path: str) -> str:
    """Return the string at ``path``, which must not be empty."""
    text = parameters.text(path)
    if not text:
        entry = parameters.find(path) or parameters.entry
        raise ConfigError(f"'{entry.key}' must not be empty", entry.location)
    return text
