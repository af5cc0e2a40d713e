"""Rules for ros_control's YAML (ROS 1)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, final

from tool0.control.config import TYPES, ControllerConfig, parameters_of
from tool0.control.lint import OF_TOOL0, lint
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    joint_entries,
)
from tool0.description.finding import Finding, error_at
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import ConfigError, nearest_name
from tool0.lint.parameters.joint_names import unknown_joints
from tool0.lint.robot.facts import RobotFacts

OTHER_TYPES: Final = (
    "ackermann_steering_controller/AckermannSteeringController",
    "diff_drive_controller/DiffDriveController",
    "force_torque_sensor_controller/ForceTorqueSensorController",
    "four_wheel_steering_controller/FourWheelSteeringController",
    "imu_sensor_controller/ImuSensorController",
    "pos_vel_controllers/JointTrajectoryController",
    "pos_vel_acc_controllers/JointTrajectoryController",
    "velocity_controllers/JointTrajectoryController",
    "effort_controllers/JointGroupVelocityController",
    "position_controllers/ScaledJointTrajectoryController",
    "velocity_controllers/ScaledJointTrajectoryController",
    "scaled_controllers/SpeedScalingStateController",
    "ur_controllers/SpeedScalingStateController",
)
"""Controllers of ROS 1 that exist, and that tool0 does not run."""
_ROS2_MARKS = ("joint_trajectory_controller/", "joint_state_broadcaster/")
_LIKE_A_CONTROLLER = frozenset({"joints", "joint", "gains", "constraints", "pid"})
_TYPO = 0.75
_MOVEIT_KEYS = frozenset(
    {
        *("controller_list", "controller_manager_name", "controller_manager_ns"),
        *("moveit_controller_manager", "moveit_simple_controller_manager"),
    }
)
"""Keys of MoveIt; its setup assistant writes them into the same files."""


def controller_findings(
    config: ControllerConfig, robot: RobotFacts | None
) -> Iterator[Finding]:
    """Yield what is wrong with the controllers of a YAML.

    Args:
        config: What it holds.
        robot: The robot that it is for, if it is known.
    """
    joints = None
    if robot is not None:  # fixed ones take no command
        joints = [j.name for j in robot.joints.values() if j.is_movable]
    linted = [
        finding
        for finding in lint(config, joints)
        if finding.rule not in OF_TOOL0 and _is_controller(finding, config)
    ]
    yield from linted
    wrong = {f.key.partition("/")[0] for f in linted if f.severity == "error"}
    for name, entry in config.tree.root.children.items():
        if name in config.names:
            found = _Ros1Controller(config, name, entry, robot).findings()
            for finding in found:
                is_reported = finding.rule == "missing-key" and any(
                    f"did you mean '{finding.key.rpartition('/')[2]}'" in other.remedy
                    for other in linted
                )
                follows = finding.rule == "controller-fails" and name in wrong
                if not is_reported and not follows:
                    yield finding
        elif robot is None and "pid_gains" in entry.children:
            gains = entry.children["pid_gains"]  # the linter knows no joints
            yield from unknown_joints(list(gains.children.items()), robot)


def _is_controller(finding: Finding, config: ControllerConfig) -> bool:
    """Return whether an entry without a type is probably a controller.

    Other nodes have parameters in the same files.
    """
    if finding.rule != "no-type":
        return True
    if finding.key in _MOVEIT_KEYS:
        return False
    entry = config.tree.root.children[finding.key]
    return (
        "controller" in finding.key
        or "meant to be" in finding.remedy
        or len(_LIKE_A_CONTROLLER & entry.children.keys()) > 1
    )


@final
class _Ros1Controller:
    """One controller of the YAML."""

    def __init__(
        self,
        config: ControllerConfig,
        name: str,
        entry: YamlEntry,
        robot: RobotFacts | None,
    ) -> None:
        self._config, self._name, self._entry = config, name, entry
        self._robot = robot
        self._keys = entry.children
        self._type_entry = self._keys["type"]
        self._type = str(self._type_entry.scalar)

    def findings(self) -> Iterator[Finding]:
        if self._type not in TYPES:
            yield from self._unknown_type()
            return
        joints = [(str(item.scalar), item) for item in joint_entries(self._entry)]
        wrong = [
            *self._missing(),
            *unknown_joints(joints, self._robot),
            *self._interfaces(joints),
        ]
        if not wrong or self._robot is None:
            wrong += self._gains(joints)
        yield from wrong
        if not wrong:
            yield from self._values(joints)

    def _missing(self) -> Iterator[Finding]:
        """Yield keys without which it does not load."""
        patterns = parameters_of(self._type)
        publishes = "publish_rate" in patterns
        for key in ("publish_rate",) if publishes else ("joints", "joint"):
            if key in patterns and key not in self._keys:
                yield error_at(
                    self._entry.location,
                    "missing-key",
                    f"{self._name}/{key}",
                    f"is missing, and {self._type} does not load without",
                    f"write '{key}' under '{self._name}'",
                )

    def _unknown_type(self) -> Iterator[Finding]:
        written, known = self._type, (*TYPES, *OTHER_TYPES)
        if written in known:
            return
        if written.startswith(_ROS2_MARKS):
            message = f"'{written}' is a controller of ROS 2, in a file for ROS 1"
            remedy = "write effort_controllers/… or position_controllers/…"
        else:
            near = nearest_name(written, known, _TYPO)
            package = written.partition("/")[0]
            of_package = [name for name in known if name.startswith(f"{package}/")]
            if near is not None:
                remedy = f"did you mean '{near}'?"
            elif of_package:
                remedy = f"valid: {', '.join(of_package)}"
            elif "/" not in written:
                remedy = "write it as package/Class"
            else:
                return  # a controller of the user's own
            message = f"there is no controller type '{written}', so it does not load"
        yield self._type_entry.finding("unknown-type", message, remedy)

    def _interfaces(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        """Yield joints that this controller cannot command."""
        wanted = INTERFACE_OF_PACKAGE.get(self._type.partition("/")[0])
        robot = self._robot
        if robot is None:
            return
        for name, entry in joints:
            joint = robot.joints.get(name)
            if joint is None or not joint.is_movable:
                continue
            offered = robot.interfaces_of(name)
            if not offered and joint.mimic_of:
                yield entry.finding(
                    "no-transmission",
                    f"'{name}' follows '{joint.mimic_of}' and takes no command",
                    f"name '{joint.mimic_of}' instead",
                )
            elif not offered:
                yield entry.finding(
                    "no-transmission",
                    f"'{name}' has no <transmission>, so ros_control cannot find it",
                    "give it one in the robot's description",
                )
            elif wanted is not None and not offered[0].written.endswith(wanted.value):
                is_clear = offered[0].meant is not None
                if is_clear or offered[0].written:
                    yield entry.finding(
                        "interface-mismatch",
                        f"{self._type} commands {wanted.value}, but the <transmission> "
                        f"of '{name}' ({offered[0].location}) offers "
                        f"'{offered[0].written}'",
                        "change the controller's type, or the interface",
                    )

    def _gains(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        """Yield joints without the gains that this controller needs."""
        patterns = parameters_of(self._type)
        for pattern, path in (
            ("gains/*/p", "gains/{}"),
            ("*/pid/p", "{}/pid"),
            ("pid/p", "pid"),
        ):
            if pattern not in patterns:
                continue
            for name, _ in joints:
                gains = self._entry.find(path.format(name))
                if gains is not None and "p" in gains.children:
                    continue
                outer = gains or self._entry.find(path.format(name).rpartition("/")[0])
                yield (outer or self._entry).finding(
                    "missing-gains",
                    f"lacks the gains of '{name}': {self._type} closes the loop itself "
                    "and needs at least p",
                    f"write {self._name}/{path.format(name)}: {{p: …, i: …, d: …}}",
                )

    def _values(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        """Yield what else keeps the controller from loading."""
        robot = RobotJoints.assumed((name for name, _ in joints), self._type)
        try:
            self._config.spec(self._name, robot)
        except ConfigError as error:
            yield error_at(
                error.location or self._entry.location,
                "controller-fails",
                self._name,
                error.message,
            )
