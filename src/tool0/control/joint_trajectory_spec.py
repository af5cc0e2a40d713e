"""The parameters of a JointTrajectoryController."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    controlled_joints,
    read_gains,
)
from tool0.control.pid import Gains
from tool0.control.tolerances import (
    DEFAULT_GOAL_TIME,
    DEFAULT_STOPPED_VELOCITY,
    JointTolerances,
    Tolerance,
    TrajectoryTolerances,
)
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.hardware.joint_state import JointState

if TYPE_CHECKING:
    from tool0.control.joint_trajectory import JointTrajectoryController


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointTrajectorySpec:
    """Everything a JointTrajectoryController is made of."""

    name: str
    type: str
    joint_models: tuple[Joint, ...]
    interface: Interface
    gains: tuple[Gains, ...] = ()
    """One per joint; none for the position interface."""
    velocity_ff: tuple[float, ...] = ()
    """Command per desired velocity, one per joint; none for the position interface."""
    tolerances: TrajectoryTolerances
    stop_trajectory_duration: float = 0.0
    """Length of the ramp to rest [s]; 0 holds the measured position at once."""
    allow_partial_joints_goal: bool = False
    state_publish_rate: float = 50.0
    """[Hz], for the edges that publish the state; 0 is never."""
    action_monitor_rate: float = 20.0
    """[Hz], for the edges that publish feedback."""

    @property
    def waits_for_command(self) -> bool:
        """It holds by itself."""
        return False

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it claims."""
        return tuple(joint.name for joint in self.joint_models)

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> JointTrajectoryController:
        """Return a controller that holds the measured positions."""
        from tool0.control.joint_trajectory import JointTrajectoryController

        return JointTrajectoryController(self, indices, state)


def parse(parameters: Namespace, robot: RobotJoints) -> JointTrajectorySpec:
    """Return the checked parameters of a JointTrajectoryController."""
    type_name = parameters.text("type")
    interface = INTERFACE_OF_PACKAGE[type_name.partition("/")[0]]
    joints = controlled_joints(robot, parameters, interface)
    gains: tuple[Gains, ...] = ()
    velocity_ff: tuple[float, ...] = ()
    if interface is not Interface.POSITION:
        why = f"{type_name} needs"
        gains = tuple(
            read_gains(parameters, f"gains/{joint.name}", why) for joint in joints
        )
        velocity_ff = tuple(
            parameters.number(f"velocity_ff/{joint.name}", 0.0) for joint in joints
        )
    return JointTrajectorySpec(
        name=parameters.name,
        type=type_name,
        joint_models=joints,
        interface=interface,
        gains=gains,
        velocity_ff=velocity_ff,
        tolerances=_tolerances(parameters, joints),
        stop_trajectory_duration=parameters.not_negative(
            "stop_trajectory_duration", 0.0
        ),
        allow_partial_joints_goal=parameters.boolean(
            "allow_partial_joints_goal", default=False
        ),
        state_publish_rate=parameters.not_negative("state_publish_rate", 50.0),
        action_monitor_rate=parameters.not_negative("action_monitor_rate", 20.0),
    )


def _tolerances(
    parameters: Namespace, joints: tuple[Joint, ...]
) -> TrajectoryTolerances:
    read = parameters.not_negative
    stopped = read("constraints/stopped_velocity_tolerance", DEFAULT_STOPPED_VELOCITY)
    return TrajectoryTolerances(
        joints={
            joint.name: JointTolerances(
                path=Tolerance(read(f"constraints/{joint.name}/trajectory", 0.0)),
                goal=Tolerance(read(f"constraints/{joint.name}/goal", 0.0), stopped),
            )
            for joint in joints
        },
        goal_time=read("constraints/goal_time", DEFAULT_GOAL_TIME),
    )
