"""Rules for the YAML files of ros_control (ROS 1)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, final

from tool0.control.config import ControllerConfig
from tool0.control.controller_parts import CATALOGUE_JOINTS
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    joint_entries,
)
from tool0.control.ros1.dialect import ROS1
from tool0.control.ros1.lint import OF_TOOL0, lint
from tool0.description.finding import Finding, Severity, error_at
from tool0.description.model import Interface
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import ConfigError, is_typo, nearest_name
from tool0.lint.plugins import PluginIndex
from tool0.lint.robot.facts import InterfaceFacts, RobotFacts

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
    "pass_through_controllers/JointTrajectoryController",
    "pass_through_controllers/CartesianTrajectoryController",
    "pose_controllers/CartesianTrajectoryController",
    "position_controllers/CartesianTrajectoryController",
    "twist_controllers/CartesianTrajectoryController",
    "velocity_controllers/CartesianTrajectoryController",
    "cartesian_trajectory_publisher/CartesianTrajectoryPublisher",
    "ros_controllers_cartesian/TwistController",
    "industrial_robot_status_controller/IndustrialRobotStatusController",
)
"""Controllers of ROS 1 that exist but that tool0 cannot run."""
_ROS2_MARKS = ("joint_trajectory_controller/", "joint_state_broadcaster/")
_LIKE_A_CONTROLLER = frozenset({"joints", "joint", "gains", "constraints", "pid"})
_ENOUGH = 0.6
"""Fraction of a list's joints that the usual robot must have.  If the fraction is
smaller, the list is assumed to be for another robot."""
_MOVEIT_KEYS = frozenset(
    {
        *("controller_list", "controller_manager_name", "controller_manager_ns"),
        *("moveit_controller_manager", "moveit_simple_controller_manager"),
    }
)
"""Keys of MoveIt.  MoveIt's setup assistant writes these keys into the same files."""
_KINEMATICS = "kinematics_solver"
"""Prefix of MoveIt's keys for a joint group."""


def controller_findings(
    config: ControllerConfig,
    robot: RobotFacts | None,
    plugins: PluginIndex,
    started: Collection[str] = (),
) -> Iterator[Finding]:
    """Yield the faults of controllers in YAML, for ``robot`` if it is known."""
    joints = None if robot is None else robot.movable_joints
    linted = [
        finding
        for finding in lint(config.tree, joints)
        if finding.rule not in OF_TOOL0 and _is_controller(finding, config)
    ]
    yield from linted
    wrong = {f.key.partition("/")[0] for f in linted if f.severity == "error"}
    for name, entry in config.tree.root.children.items():
        if name in config.names:
            controller = _Ros1Controller(config, name, entry, robot, plugins, started)
            for finding in controller.findings():
                key = finding.key.rpartition("/")[2]
                is_reported = finding.rule == "missing-key" and any(
                    f"did you mean '{key}'" in other.remedy for other in linted
                )
                follows = finding.rule == "controller-fails" and name in wrong
                if not is_reported and not follows:
                    yield finding
        elif robot is None and "pid_gains" in entry.children:
            # the controllers' linter does not check joint names
            gains = entry.children["pid_gains"]
            yield from unknown_joints(list(gains.children.items()), robot)


def _is_controller(finding: Finding, config: ControllerConfig) -> bool:
    """Return whether an entry without a type is probably a controller.

    The same YAML file may also contain parameters of other nodes.
    """
    if finding.rule != "no-type":
        return True
    if finding.key in _MOVEIT_KEYS:
        return False
    entry = config.tree.root.children[finding.key]
    if any(key.startswith(_KINEMATICS) for key in entry.children):
        return False
    return (
        "controller" in finding.key
        or "meant to be" in finding.remedy
        or len(_LIKE_A_CONTROLLER & entry.children.keys()) > 1
    )


@final
@dataclass(frozen=True, slots=True)
class _Ros1Controller:
    """One controller in the YAML file."""

    config: ControllerConfig
    name: str
    entry: YamlEntry
    robot: RobotFacts | None
    plugins: PluginIndex
    started: Collection[str]
    """Controllers that a launch file starts; empty if they are unknown."""

    @property
    def type(self) -> str:
        return str(self.entry.children["type"].scalar)

    def findings(self) -> Iterator[Finding]:
        if self.type not in ROS1.types:
            yield from self._unknown_type()
            return
        joints = [(str(item.scalar), item) for item in joint_entries(self.entry)]
        wrong = [
            *self._missing(),
            *unknown_joints(joints, self.robot),
            *self._interfaces(joints),
        ]
        if not wrong or self.robot is None:
            wrong += self._gains(joints)
        yield from wrong
        if not wrong:
            yield from self._values(joints)

    def _missing(self) -> Iterator[Finding]:
        """Yield the missing keys that the controller needs in order to be loaded."""
        patterns = ROS1.parameters_of(self.type)
        publishes = "publish_rate" in patterns
        for key in ("publish_rate",) if publishes else ("joints", "joint"):
            if key in patterns and key not in self.entry.children:
                yield error_at(
                    self.entry.location,
                    "missing-key",
                    f"{self.name}/{key}",
                    f"is missing, and {self.type} does not load without it",
                    f"write '{key}' under '{self.name}'",
                )

    def _unknown_type(self) -> Iterator[Finding]:
        written, known = self.type, (*ROS1.types, *OTHER_TYPES)
        if written in known or written in self.plugins:
            return
        near = nearest_name(written, known)
        classes = [name for name in known if name.endswith(f"/{written}")]
        severity: Severity = "error"
        message = f"there is no controller type '{written}', so it does not load"
        if written.startswith(_ROS2_MARKS):
            message = f"'{written}' is a controller of ROS 2, in a file for ROS 1"
            remedy = "write effort_controllers/… or position_controllers/…"
        elif near is not None and is_typo(written, near):
            remedy = f"did you mean '{near}'?"
        elif classes:
            remedy = f"write {' or '.join(classes)}"
        else:
            severity = "warning"
            message = f"no package here exports the controller type '{written}'"
            remedy = "put its package into the workspace, or source its workspace"
        yield self.entry.children["type"].finding(
            "unknown-type", message, remedy, severity
        )

    def _interfaces(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        """Yield the joints that this controller cannot command."""
        wanted = INTERFACE_OF_PACKAGE.get(self.type.partition("/")[0])
        for name, entry in () if self.robot is None else joints:
            joint = None if self.robot is None else self.robot.joints.get(name)
            if self.robot is None or joint is None or not joint.is_movable:
                continue
            offered = self.robot.interfaces_of(name)
            if not offered and joint.mimic_of:
                yield entry.finding(
                    "no-transmission",
                    f"'{name}' follows '{joint.mimic_of}' and takes no command",
                    f"name '{joint.mimic_of}' instead",
                )
            elif not offered and self.robot.transmissions:
                # A robot without any transmission is not for Gazebo.  The robot's own
                # driver needs no transmissions.
                yield entry.finding(
                    "no-transmission",
                    f"'{name}' has no <transmission>, so ros_control cannot find it",
                    "give it one in the robot's description",
                )
            elif wanted is not None and offered and not _fits(offered[0], wanted):
                if not self.is_meant_for(name, offered[0]):
                    continue
                yield entry.finding(
                    "interface-mismatch",
                    f"{self.type} commands {wanted.value}, but the <transmission> "
                    f"of '{name}' ({offered[0].at.location}) offers "
                    f"'{offered[0].written}'",
                    "change the controller's type, or the interface",
                )
                return  # the other joints probably have the same fault

    def is_meant_for(self, joint: str, offered: InterfaceFacts) -> bool:
        """Return whether a controller is meant for a joint with another interface.

        The controller is meant for the joint if a launch file starts the controller, or
        if no other controller in the YAML file fits the joint.  Many YAML files have
        one controller for each interface.
        """
        if self.started:
            return self.name in self.started
        for name, entry in self.config.tree.root.children.items():
            if name not in self.config.names or name == self.name:
                continue
            kind = INTERFACE_OF_PACKAGE.get(self.config.types[name].partition("/")[0])
            names = [str(item.scalar) for item in joint_entries(entry)]
            if kind is not None and joint in names and _fits(offered, kind):
                return False
        return True

    def _gains(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        """Yield the joints for which this controller lacks gains."""
        patterns = ROS1.parameters_of(self.type)
        for pattern, path in (
            ("gains/*/p", "gains/{}"),
            ("*/pid/p", "{}/pid"),
            ("pid/p", "pid"),
        ):
            if pattern not in patterns:
                continue
            for name, _ in joints:
                gains = self.entry.find(path.format(name))
                if gains is not None and "p" in gains.children:
                    continue
                outer = gains or self.entry.find(path.format(name).rpartition("/")[0])
                yield (outer or self.entry).finding(
                    "missing-gains",
                    f"lacks the gains of '{name}': {self.type} closes the loop itself "
                    "and needs at least p",
                    f"write {self.name}/{path.format(name)}: {{p: …, i: …, d: …}}",
                )

    def _values(self, joints: list[tuple[str, YamlEntry]]) -> Iterator[Finding]:
        """Yield other reasons why the controller cannot be loaded."""
        robot = RobotJoints.assumed((name for name, _ in joints), self.type)
        try:
            self.config.spec(self.name, robot)
        except ConfigError as error:
            yield error_at(
                error.location or self.entry.location,
                "controller-fails",
                self.name,
                error.message,
            )


def _fits(offered: InterfaceFacts, wanted: Interface) -> bool:
    """Return whether a <hardwareInterface> is ``wanted``, with or without a package."""
    written = offered.written
    return not written or written.rpartition("/")[2] == wanted.value.rpartition("/")[2]


@cache
def usual_joints() -> frozenset[str]:
    """Return the movable joints of the usual robot, which is a UR5 with a 2F-85."""
    from tool0.description.loading import assemble

    return frozenset(joint.name for joint in assemble().model.movable_joints)


_OF_HAND: Final = 3
"""Smallest number of the usual gripper's joints in a list that is meant for that
gripper."""


def unknown_joints(
    entries: Sequence[tuple[str, YamlEntry]], robot: RobotFacts | None
) -> Iterator[Finding]:
    """Yield a finding for each listed joint that the robot does not have."""
    names = [name for name, _ in entries]
    if robot is not None:
        known = set(robot.movable_joints)
        reason = "the robot has no such joint"
    else:
        known = set(usual_joints())
        if sum(name in known for name in names) < _ENOUGH * len(names):
            return
        reason = (
            "a UR with a 2F-85, like the one these joints belong to, has no such joint"
        )
    hand = known.difference(CATALOGUE_JOINTS)
    is_of_hand = len(hand.intersection(names)) >= _OF_HAND
    for name, entry in entries:
        if name in known:
            continue
        unused = known.difference(names)
        near = nearest_name(name, unused) or nearest_name(name, known)
        if robot is None and not (is_typo(name, near) or is_of_hand):
            continue
        yield entry.finding(
            "unknown-joint",
            f"names '{name}', but {reason}",
            f"did you mean '{near}'?" if near else "name one that it has",
            severity="error" if robot is not None else "warning",
        )
