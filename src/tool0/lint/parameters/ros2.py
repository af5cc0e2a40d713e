"""Rules for the YAML files of ros2_control (ROS 2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Final, final

from tool0.control.config import ControllerConfig
from tool0.control.dialect import Declared
from tool0.control.parameters import JOINT_STATES, RobotJoints, joint_entries
from tool0.control.ros1.dialect import ROS1
from tool0.control.ros2.dialect import ROS2
from tool0.control.ros2.layout import MANAGER, PARAMETERS, declared_in, places
from tool0.control.ros2.lint import lint
from tool0.control.ros2.trajectory_parameters import SPEED_SCALING
from tool0.description.finding import Finding, Severity, error_at
from tool0.description.yaml_tree import Tree, YamlEntry
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, is_typo, nearest_name
from tool0.lint.parameters.ros1 import unknown_joints
from tool0.lint.plugins import PluginIndex
from tool0.lint.robot.facts import RobotFacts

OTHER_TYPES: Final = (
    "ackermann_steering_controller/AckermannSteeringController",
    "admittance_controller/AdmittanceController",
    "bicycle_steering_controller/BicycleSteeringController",
    "chained_filter_controller/ChainedFilter",
    "diff_drive_controller/DiffDriveController",
    "gpio_controllers/GpioCommandController",
    "gps_sensor_broadcaster/GPSSensorBroadcaster",
    "imu_sensor_broadcaster/IMUSensorBroadcaster",
    "mecanum_drive_controller/MecanumDriveController",
    "motion_primitives_controllers/MotionPrimitivesForwardController",
    "omni_wheel_drive_controller/OmniWheelDriveController",
    "pid_controller/PidController",
    "range_sensor_broadcaster/RangeSensorBroadcaster",
    "steering_controllers_library/SteeringControllersLibrary",
    "tricycle_controller/TricycleController",
    "tricycle_steering_controller/TricycleSteeringController",
    "ur_controllers/FrictionModelController",
    "ur_controllers/GravityUpdateController",
    "ur_controllers/ToolContactController",
    "ur_controllers/URConfigurationController",
)
"""Controllers that exist but that tool0 cannot run."""
_MISSPELT = ("ros_parameters", "ros__parameter", "ros_parameter", "ros___parameters")
_KEYS_OF_INTERFACES: Final = (
    *("interface_name", "interface_names", "interfaces"),
    *("command_interfaces", "state_interfaces"),
)
_FILLED_IN = "$"
"""Character that marks texts that a launch file or a program replaces."""


def is_ros2(root: YamlEntry) -> bool:
    """Return whether a file has the layout of ROS 2, even if it contains a typo."""
    parts = {part for leaf in root.leaves() for part in leaf.key.split("/")}
    return not parts.isdisjoint((PARAMETERS, *_MISSPELT)) or MANAGER in root.children


def controller_findings(
    tree: Tree, robot: RobotFacts | None, plugins: PluginIndex
) -> Iterator[Finding]:
    """Yield the faults of controllers in YAML, for ``robot`` if it is known.

    The level ``ros__parameters`` is added to ``tree`` wherever it is missing.
    """
    yield from _restore_levels(tree.root)
    joints = None if robot is None else robot.movable_joints
    yield from (item for item in lint(tree, joints) if not _is_filled_in(item))
    for place in places(tree.root):
        for name, item in declared_in(tree.root, place).items():
            yield from _Ros2Controller(name, item, robot, plugins).findings()


def _is_filled_in(finding: Finding) -> bool:
    return _FILLED_IN in finding.key


def _restore_levels(root: YamlEntry) -> Iterator[Finding]:
    """Add missing or misspelled levels, and yield findings about these levels."""
    for name, entry in list(root.children.items()):
        children = entry.children
        if PARAMETERS in children:
            continue
        wrong = next((key for key in _MISSPELT if key in children), None)
        if wrong is not None:
            yield _missing_level(children[wrong], f"'{wrong}' should be '{PARAMETERS}'")
            children[PARAMETERS] = children.pop(wrong)
        elif name == MANAGER or {"joints", "command_interfaces"} & children.keys():
            yield _missing_level(
                entry, f"'{PARAMETERS}:' must stand between '{name}' and its parameters"
            )
            inner = YamlEntry(entry.key, entry.location, entry.value)
            entry.value = {PARAMETERS: inner}
        else:
            yield from _restore_levels(entry)


def _missing_level(entry: YamlEntry, remedy: str) -> Finding:
    message = "no node of ROS 2 gets these parameters"
    return entry.finding("no-ros-parameters", message, remedy)


@final
@dataclass(frozen=True, slots=True)
class _Ros2Controller:
    """One controller that the controller manager loads."""

    name: str
    declared: Declared
    robot: RobotFacts | None
    plugins: PluginIndex

    @property
    def type(self) -> str:
        return str(self.declared.type.scalar)

    @property
    def parameters(self) -> YamlEntry:
        return self.declared.parameters

    def findings(self) -> Iterator[Finding]:
        if self.type not in ROS2.types:
            yield from self._unknown_type()
            return
        missing = list(self._missing())
        yield from missing
        named = [(str(e.scalar), e) for e in joint_entries(self.parameters)]
        # chained to other controllers
        is_chained = any("/" in name for name, _ in named)
        joints = [] if is_chained else [p for p in named if _FILLED_IN not in p[0]]
        wrong: list[Finding] = []
        if self.robot is not None or len(joints) > 1:
            wrong += unknown_joints(joints, self.robot)
        wrong += self._interfaces(joints)
        yield from wrong
        if not missing and not wrong and not is_chained:
            yield from self._values()

    def _unknown_type(self) -> Iterator[Finding]:
        if self.type in OTHER_TYPES or self.type in self.plugins:
            return
        near = nearest_name(self.type, (*ROS2.types, *OTHER_TYPES))
        severity: Severity = "error"
        if self.type in ROS1.types:
            kind = self.type.partition("/")[2]
            same = [name for name in ROS2.types if name.endswith(f"/{kind}")]
            remedy = f"write '{same[0]}'" if same else "write joint_state_broadcaster/…"
            message = f"'{self.type}' is a controller of ROS 1, in a file for ROS 2"
        elif is_typo(self.type, near):
            message = f"there is no controller type '{self.type}'"
            remedy = f"did you mean '{near}'?"
        else:
            severity = "warning"
            message = f"no package here exports the controller type '{self.type}'"
            remedy = "put its package into the workspace"
        yield self.declared.type.finding("unknown-type", message, remedy, severity)

    def _missing(self) -> Iterator[Finding]:
        required = _required(self.type)
        missing = [key for key in required if key not in self.parameters.children]
        if missing:
            yield self.parameters.finding(
                "missing-key",
                f"{self.type} does not configure without {' and '.join(missing)}",
                f"write them under '{self.name}: {PARAMETERS}:'",
            )

    def _interfaces(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        keys = self.parameters.children
        entry = keys.get("command_interfaces")
        wanted = [str(item.scalar) for item in (entry.items if entry else ())]
        if "effort" in wanted and "position" not in wanted and "gains" not in keys:
            yield (entry or self.declared.type).finding(
                "missing-gains",
                "commands effort, so it closes the loop itself and needs gains",
                f"write gains: {{<joint>: {{p: …}}}} under {self.name}",
            )
        if self.robot is None or not self.robot.ros2_joints:
            return
        for name, place in joints:
            offered = self.robot.ros2_joints.get(name)
            lacking = [kind for kind in wanted if kind not in (offered or ())]
            if offered is None and name in self.robot.joints:
                yield place.finding(
                    "no-transmission",
                    f"'{name}' is not in the robot's <ros2_control>",
                    "add it there, with its command interfaces",
                )
            elif offered is not None and lacking:
                yield place.finding(
                    "interface-mismatch",
                    f"commands {', '.join(lacking)}, but <ros2_control> offers "
                    f"{', '.join(offered) or 'nothing'} for '{name}'",
                    "change command_interfaces, or the robot's <ros2_control>",
                )

    def _has_other_hardware(self) -> bool:
        """Return whether the controller uses interfaces that tool0's joints lack."""
        entries = map(self.parameters.children.get, _KEYS_OF_INTERFACES)
        return any(
            str(item.scalar) not in JOINT_STATES
            and not is_typo(
                str(item.scalar), nearest_name(str(item.scalar), JOINT_STATES)
            )
            for entry in entries
            if entry is not None
            for item in (entry.items if entry.is_list else [entry])
        )

    def _values(self) -> Iterator[Finding]:
        """Yield another reason why the controller cannot be loaded."""
        texts = (leaf.plain() for leaf in self.parameters.leaves())
        if any(_FILLED_IN in str(text) for text in texts) or self._has_other_hardware():
            return
        names = [str(entry.scalar) for entry in joint_entries(self.parameters)]
        arms = [
            str(leaf.scalar).removesuffix(SPEED_SCALING)
            for leaf in self.parameters.leaves()
            if str(leaf.scalar).endswith(SPEED_SCALING)
        ]
        robot = replace(
            RobotJoints.assumed(names, self.type),
            speed_scaling=dict.fromkeys(arms, 1.0),  # any name of an arm is accepted
        )
        parse = ROS2.parser_of(self.type, self.declared.type.location)
        try:
            parse(self.name, self.type, Namespace(self.parameters), robot)
        except ConfigError as error:
            yield error_at(
                error.location or self.parameters.location,
                "controller-fails",
                self.name,
                error.message,
            )


@cache
def _required(type_name: str) -> tuple[str, ...]:
    """Return the parameters without which a controller cannot be configured."""
    parse = ROS2.parser_of(type_name, None)
    sample = ControllerConfig.from_text(ROS2.sample).tree.root
    robot = RobotJoints.assumed("*", type_name)
    needed = []
    for key in sorted(ROS2.parameters_of(type_name) & sample.children.keys()):
        others = {k: v for k, v in sample.children.items() if k != key}
        shorter = YamlEntry("", sample.location, others)
        try:
            parse("sample", type_name, Namespace(shorter), robot)
        except ConfigError as error:
            if f"lacks '{key}'" in error.message:
                needed.append(key)
    return tuple(needed)
