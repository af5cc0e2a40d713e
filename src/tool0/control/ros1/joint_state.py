"""JointStateController: the joints that it publishes, and its publication rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from tool0.control.parameters import RobotJoints
from tool0.control.passive import PassiveController
from tool0.description.model import Interface
from tool0.description.yaml_tree import YamlEntry
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean
from tool0.hardware.engine import JointState
from tool0.protocol.controllers import Gains


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ExtraJoint:
    """A joint that exists only in the published messages."""

    name: str
    position: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedJointState:
    """The content of a sensor_msgs/JointState message."""

    names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointStateSpec:
    """The parameters of a JointStateController, which claims no joints."""

    name: str
    type: str
    joints: tuple[str, ...]
    """The published joints of the robot, in the order of the messages."""
    publish_rate: float
    """Publication rate of the state [Hz]; a rate of 0 or less disables publication."""
    extra_joints: tuple[ExtraJoint, ...] = ()

    interface: ClassVar[Interface | None] = None
    gains: ClassVar[tuple[Gains, ...]] = ()
    further_interfaces: ClassVar[tuple[str, ...]] = ()
    state_interfaces: ClassVar[tuple[str, ...]] = ()
    waits_for_command: ClassVar[bool] = False

    def start(self, indices: Sequence[int], state: JointState) -> PassiveController:
        """Return a controller; ``indices`` and ``state`` are not used."""
        del indices, state
        return PassiveController()

    def message(
        self,
        joint_names: Sequence[str],
        position: Sequence[float],
        velocity: Sequence[float],
        effort: Sequence[float],
    ) -> PublishedJointState:
        """Return the message to publish.

        The values of extra joints are the values in the YAML.

        All arguments have shape (n_joints,), in the order of ``joint_names``.
        """
        picked = [joint_names.index(name) for name in self.joints]
        extra = self.extra_joints
        return PublishedJointState(
            names=(*self.joints, *(joint.name for joint in extra)),
            position=(*(position[i] for i in picked), *(j.position for j in extra)),
            velocity=(*(velocity[i] for i in picked), *(j.velocity for j in extra)),
            effort=(*(effort[i] for i in picked), *(j.effort for j in extra)),
        )


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> JointStateSpec:
    """Return the checked parameters of a JointStateController.

    Without the parameter ``joints``, the controller publishes the joints with a
    transmission, sorted by name.  ROS uses the same order, since it stores the joints
    in a map.  ``joints`` can list any movable joints, which are published in the given
    order.
    """
    joints = tuple(sorted(robot.interfaces))
    if parameters.find("joints") is not None:
        joints = parameters.texts("joints")
        entry = parameters.find("joints") or parameters.entry
        movable = [key for key, joint in robot.joints.items() if joint.is_movable]
        for joint in joints:
            if joint not in movable:
                raise ConfigError(
                    f"'{entry.key}' names unknown joint '{joint}'"
                    + did_you_mean(joint, movable),
                    entry.location,
                )
    return JointStateSpec(
        name=name,
        type=type_name,
        joints=joints,
        publish_rate=parameters.number("publish_rate"),
        extra_joints=_extra_joints(parameters, joints),
    )


def _extra_joints(
    parameters: Namespace, joints: tuple[str, ...]
) -> tuple[ExtraJoint, ...]:
    """Read the extra joints; joints that are already published are skipped.

    Already published joints are also skipped in ROS.  Unlike ROS, ``_extra_joints``
    accepts ``position: 0`` as well as ``position: 0.0``.
    """
    entry = parameters.find("extra_joints")
    if entry is None:
        return ()
    if not entry.is_list:
        raise ConfigError(
            f"'{entry.key}' must be a list of mappings with a name, "
            f"got {entry.describe()}",
            entry.location,
        )
    extra = map(_extra_joint, entry.items)
    return tuple(joint for joint in extra if joint.name not in joints)


def _extra_joint(entry: YamlEntry) -> ExtraJoint:
    if not entry.is_mapping:
        raise ConfigError(
            f"'{entry.key}' must be a mapping with a name, got {entry.describe()}",
            entry.location,
        )
    joint = Namespace(entry)
    return ExtraJoint(
        name=joint.text("name"),
        position=joint.number("position", 0.0),
        velocity=joint.number("velocity", 0.0),
        effort=joint.number("effort", 0.0),
    )
