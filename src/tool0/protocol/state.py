"""The whole robot at one instant, as an immutable value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, Protocol, final

from msgspec import UNSET, Struct, UnsetType, field

from tool0.description.scene import SceneObject
from tool0.description.scene_state import Contact, ObjectState, Wrench, contacts_text
from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.controllers import ControllerStatus
from tool0.protocol.trajectories import TrajectoryState

MotionMode = Literal[
    "free", "hold", "path", "servo", "speed", "stop", "freedrive", "torque"
]
"""Source of an arm's motion; ``free`` means a ROS controller or no source."""

SNAPSHOT_PERIOD = 0.008
"""Default simulated time between snapshots [s].  The resulting rate of 125 Hz is also
that of a real UR's state reports."""


def ticks_between_snapshots(period: float, control_period: float) -> int:
    """Return the number of control periods between snapshots for a ``period`` [s].

    The result is the largest number that fits into ``period`` and that is a divisor of
    the number for the default period.
    """
    default = max(1, round(SNAPSHOT_PERIOD / control_period))
    wanted = max(1, math.floor(period / control_period + 1e-9))
    return max(n for n in range(1, default + 1) if default % n == 0 and n <= wanted)


class JointSetpoint(NamedTuple):
    """A controller's setpoint for one joint."""

    position: float
    """Position at this instant [rad | m]."""
    velocity: float
    """Velocity at this instant [rad/s | m/s]."""
    target: float
    """Position at the end of the motion [rad | m]."""


class ControllerSetpoint(Protocol):
    """A controller's setpoint at one instant, computed on access."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of all sequences of this class."""

    def joint_setpoints(self) -> Mapping[str, JointSetpoint]:
        """Return the setpoint of each joint."""

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the desired and the final position of one joint [rad | m].

        The result is None if the joint is not in ``joint_names``.  This method is much
        faster than ``joint_setpoints``.
        """

    def desired_motion(self, joints: Sequence[str], time: float) -> ArmSetpoint | None:
        """Return the desired motion of these joints at a simulated time [s].

        The result is None if one of the joints is not in ``joint_names``.
        """

    def state(self) -> TrajectoryState:
        """Return the desired and measured motion and the error at this instant."""


@final
class ArmSample(Struct, frozen=True):
    """Motion of an arm, the source of the motion, and the wrench on the tool."""

    mode: MotionMode
    """Source of the motion; ``free`` means a ROS controller or no source."""
    setpoint: ArmSetpoint | None
    """Setpoint of the arm, or the measured motion if the arm is not driven.  The
    setpoint is sent as [positions, velocities, accelerations], from base to flange
    [rad, rad/s, rad/s²].  The value is None only within the simulation's process, if a
    controller has the setpoint."""
    path: int
    """Number of the last path; 0 before the first path."""
    path_time: float
    """Time on the last path [s]; it advances more slowly if the speed is scaled."""
    is_done: bool
    """Whether the path or the deceleration has ended with the setpoint at rest; false
    after a failure."""
    force_mode: bool
    """Whether force mode is active; the setpoint does not include the resulting
    deviation."""
    wrench: Wrench
    """External force [N] and torque [N·m] on the tool at the flange, in the axes of the
    flange, without the payload and the tare."""
    failure: str = ""
    """Reason why the motion failed.  After a failure, the arm holds its position, and
    accepts no motion until it is taken again.  Empty if the motion did not fail."""
    joint_names: tuple[str, ...] | UnsetType = UNSET
    """Names of the joints from base to flange; set only in the simulation's process."""
    currents: tuple[float, ...] = ()
    """Motor currents of a real arm [A], from base to flange; empty for a simulated
    arm."""


@final
class Snapshot(Struct, frozen=True):
    """The whole robot at one instant.

    The class is a msgspec struct because the loop creates a snapshot every eight steps;
    a dataclass would take ten times as long.
    """

    time: float
    """Simulated time [s]."""
    tick: int
    """Number of control periods since the start or the last reset."""
    joint_names: tuple[str, ...]
    """Names of all movable joints, in the order of ``position``, ``velocity`` and
    ``effort``."""
    position: tuple[float, ...]
    """Measured positions [rad | m], shape (n_joints,)."""
    velocity: tuple[float, ...]
    """Measured velocities [rad/s | m/s], shape (n_joints,)."""
    effort: tuple[float, ...]
    """Efforts applied during the last step [N·m | N], shape (n_joints,)."""
    controllers: tuple[ControllerStatus, ...]
    """Status of every loaded controller."""
    is_paused: bool = False
    """Whether simulated time is paused."""
    is_stopped: bool = False
    """Whether the emergency stop is engaged."""
    real_time_factor: float = 1.0
    """Ratio of simulated time to wall time, measured over roughly the last second."""
    overruns: int = 0
    """Number of ticks that have begun more than one control period late since the
    start."""
    late_ticks: int = 0
    """Number of ticks that began more than one control period late over roughly the
    last second of wall time."""
    fault: str | None = None
    """Reason why the simulation is stopped until a reset; None if it is not stopped."""
    speed: float | None = None
    """Requested ratio of simulated time to wall time; None if time passes only on
    request, as fast as possible."""
    controller_setpoints: Mapping[str, ControllerSetpoint] = field(default_factory=dict)
    """Setpoint of each running controller, by name; empty in other processes."""
    received_setpoints: Mapping[str, JointSetpoint] = field(default_factory=dict)
    """Joint → setpoint, for snapshots received from another process."""
    scene: tuple[SceneObject, ...] = ()
    """Objects around the robot.  The tuple is the same object until an object is added
    or removed."""
    objects: Sequence[ObjectState] = ()
    """Poses and velocities of the objects, in the order of ``scene``."""
    stalls: tuple[Stall, ...] = ()
    """Joints that push at their effort limit without moving, and the bodies in
    contact."""
    gripping: tuple[str, ...] = ()
    """Names of the grippers that press on an object from two sides."""
    control_boxes: tuple[ControlBoxState, ...] = ()
    """Control box of each arm.  The tuple is the same object until a control box
    changes."""
    command: tuple[float, ...] = ()
    """Last command of each joint, in the unit of the command interface; empty unless a
    subscriber needs commands."""
    arms: Mapping[str, ArmSample] = field(default_factory=dict)
    """Arm → motion of the arm; empty unless a subscriber needs the motions."""
    contacts: tuple[Contact, ...] = ()
    """Contacts with their forces; empty unless a subscriber needs contacts."""
    step: int = 0
    """Number of control periods since the bring-up; a reset does not change this
    number.  The number is set only in the simulation's process."""

    @property
    def positions(self) -> dict[str, float]:
        """Joint → position [rad | m]."""
        return dict(zip(self.joint_names, self.position, strict=True))

    def setpoints(self) -> Mapping[str, JointSetpoint]:
        """Return the setpoint of each joint whose position a controller commands.

        The setpoints are computed in the calling thread.
        """
        if not self.controller_setpoints:
            return self.received_setpoints
        found: dict[str, JointSetpoint] = {}
        for setpoint in self.controller_setpoints.values():
            found.update(setpoint.joint_setpoints())
        return found

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the desired and the final position of one joint [rad | m].

        The result is None if no controller commands the joint's position.  This method
        is much faster than ``setpoints``.
        """
        for setpoint in self.controller_setpoints.values():
            wanted = setpoint.desired_and_target(joint)
            if wanted is not None:
                return wanted
        received = self.received_setpoints.get(joint)
        return None if received is None else (received.position, received.target)


class ArmSetpoint(NamedTuple):
    """Commanded motion of an arm at one instant, with joints from base to flange."""

    positions: Sequence[float]
    """Positions [rad]."""
    velocities: Sequence[float]
    """Velocities in simulated time [rad/s]."""
    accelerations: Sequence[float]
    """Accelerations [rad/s²]."""

    @property
    def is_at_rest(self) -> bool:
        """Whether all joints are stationary."""
        return not any(self.velocities)

    @staticmethod
    def resting(positions: Sequence[float]) -> ArmSetpoint:
        """Return the setpoint of an arm that is at rest at ``positions`` [rad]."""
        zeros = (0.0,) * len(positions)
        return ArmSetpoint(tuple(positions), zeros, zeros)


Six = tuple[float, float, float, float, float, float]
"""One number per arm joint from base to flange, or a wrench (force and torque)."""


class Stall(NamedTuple):
    """A driven joint that pushes, but has not moved for ``STALL_TIME``."""

    joint: str
    """Name of the joint."""
    effort: float
    """Effort with which the joint pushes [N·m | N]."""
    contacts: tuple[tuple[str, str], ...] = ()
    """Contacts, strongest first: pairs of a link beyond the joint and the body that it
    touches.  Empty if the joint is at its mechanical stop or is overloaded."""
    lag: float | None = None
    """Distance of the joint from its setpoint [rad | m]; None if it is at its effort
    limit."""

    def __str__(self) -> str:
        touching = contacts_text(self.contacts)
        touching = touching or "no contact: a joint stop, or the load"
        does = f"is at its effort limit of {abs(self.effort):.4g}"
        if self.lag is not None:
            does = f"is {self.lag:.3f} from its setpoint"
        return f"joint '{self.joint}' {does} and does not move ({touching})"


MIN_SNAPSHOT_RATE, MAX_SNAPSHOT_RATE = 0.001, 500.0
"""Range of snapshot rates for subscribers, in simulated time [Hz]."""
