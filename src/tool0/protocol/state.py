"""The whole robot at one instant, as a frozen value."""

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
"""Source of an arm's motion: ``free`` is a controller of ROS, or nothing."""

SNAPSHOT_PERIOD = 0.008
"""Default simulated time between snapshots [s]: 125 Hz, the rate of the UR's own
reports."""


def ticks_between_snapshots(period: float, control_period: float) -> int:
    """Return the control periods between snapshots at least every ``period`` [s].

    It is the largest such number that divides that of the default period.
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
    """The end of the motion [rad | m]."""


class ControllerSetpoint(Protocol):
    """The setpoint of a controller at one instant, computed when it is read."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of every sequence here."""

    def joint_setpoints(self) -> Mapping[str, JointSetpoint]:
        """Return the setpoint of each joint."""

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the desired and the final position of one joint [rad | m].

        None if it is none of these; much cheaper than ``joint_setpoints``.
        """

    def desired_motion(self, joints: Sequence[str], time: float) -> ArmSetpoint | None:
        """Return the desired motion of these joints at a simulated time [s].

        None if one is none of these.
        """

    def state(self) -> TrajectoryState:
        """Return desired, actual and error at that instant."""


@final
class ArmSample(Struct, frozen=True):
    """Motion of an arm, its source, and the wrench on its tool."""

    mode: MotionMode
    """Source of the motion: ``free`` is a controller of ROS, or nothing."""
    setpoint: ArmSetpoint | None
    """Setpoint of the arm, or its measured motion if nothing drives it.  Sent as
    [positions, velocities, accelerations], base to flange [rad] and per second.  None
    only in a snapshot of this process: the setpoint is then its controller's."""
    path: int
    """Number of the last path; 0 before the first."""
    path_time: float
    """Time on that path [s]; it passes more slowly if the speed is scaled."""
    is_done: bool
    """Whether the path has arrived at its end, or the stop has ended: the setpoint is
    at rest.  Not after a failure."""
    force_mode: bool
    """Whether it pushes with a force; the setpoint is the motion without it."""
    wrench: Wrench
    """External force [N] and torque [N·m] on the tool at the flange, in its axes, less
    the payload and the tare."""
    failure: str = ""
    """Why the motion failed: the arm rests where it was, and accepts no motion until it
    is taken again.  Empty if it did not."""
    joint_names: tuple[str, ...] | UnsetType = UNSET
    """Joints from base to flange; only in the process of the simulation."""
    currents: tuple[float, ...] = ()
    """Motor currents of a real arm [A], base to flange; empty for a simulated one."""


@final
class Snapshot(Struct, frozen=True):
    """The whole robot at one instant.

    A struct of msgspec: the loop creates one for every eight steps, and a dataclass
    would take ten times as long.
    """

    time: float
    """Simulated time [s]."""
    tick: int
    """Control periods since the start or the last reset."""
    joint_names: tuple[str, ...]
    """Every movable joint: the order of the three sequences that follow."""
    position: tuple[float, ...]
    """Measured positions [rad | m], shape (n_joints,)."""
    velocity: tuple[float, ...]
    """Measured velocities [rad/s | m/s], shape (n_joints,)."""
    effort: tuple[float, ...]
    """Efforts applied during the last step [N·m | N], shape (n_joints,)."""
    controllers: tuple[ControllerStatus, ...]
    """Every loaded controller."""
    is_paused: bool = False
    """Whether simulated time is held."""
    is_stopped: bool = False
    """Whether the emergency stop is engaged."""
    real_time_factor: float = 1.0
    """Simulated time per wall time, over about the last second."""
    overruns: int = 0
    """Ticks that began more than one control period late, since the start."""
    late_ticks: int = 0
    """The same, in about the last second of wall time."""
    fault: str | None = None
    """Why the simulation has stopped, until a reset."""
    speed: float | None = None
    """Requested simulated time per wall time; None if time passes only on request, as
    fast as possible."""
    controller_setpoints: Mapping[str, ControllerSetpoint] = field(default_factory=dict)
    """The setpoint of each running controller; empty in another process."""
    received_setpoints: Mapping[str, JointSetpoint] = field(default_factory=dict)
    """Joint → setpoint, if another process computed them."""
    scene: tuple[SceneObject, ...] = ()
    """The objects around the robot: the same tuple until one is added or removed."""
    objects: Sequence[ObjectState] = ()
    """Poses and velocities of the objects, in the order of ``scene``."""
    stalls: tuple[Stall, ...] = ()
    """Joints that push at their effort limit without moving, and what they touch."""
    gripping: tuple[str, ...] = ()
    """The grippers whose fingers press on something from two sides."""
    control_boxes: tuple[ControlBoxState, ...] = ()
    """The control box of each arm: the same tuple until one changes."""
    command: tuple[float, ...] = ()
    """The last command of each joint, in the unit of its interface; empty unless a
    subscriber needs it."""
    arms: Mapping[str, ArmSample] = field(default_factory=dict)
    """Arm → what moves it; empty unless a subscriber needs it."""
    contacts: tuple[Contact, ...] = ()
    """Contacts with their forces; empty unless a subscriber needs them."""
    step: int = 0
    """Control periods since the bring-up; no reset sets it back.  Only in the process
    of the simulation."""

    @property
    def positions(self) -> dict[str, float]:
        """Joint → position [rad | m]."""
        return dict(zip(self.joint_names, self.position, strict=True))

    def setpoints(self) -> Mapping[str, JointSetpoint]:
        """Return the setpoint of each joint that a controller moves by position.

        It is computed here, in the thread of the reader.
        """
        if not self.controller_setpoints:
            return self.received_setpoints
        found: dict[str, JointSetpoint] = {}
        for setpoint in self.controller_setpoints.values():
            found.update(setpoint.joint_setpoints())
        return found

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the desired and the final position of one joint [rad | m].

        None if no controller moves it by position.  Much cheaper than ``setpoints``.
        """
        for setpoint in self.controller_setpoints.values():
            wanted = setpoint.desired_and_target(joint)
            if wanted is not None:
                return wanted
        received = self.received_setpoints.get(joint)
        return None if received is None else (received.position, received.target)


class ArmSetpoint(NamedTuple):
    """The commanded motion of an arm's joints at an instant, base to flange."""

    positions: Sequence[float]
    """Positions [rad]."""
    velocities: Sequence[float]
    """Velocities in simulated time [rad/s]."""
    accelerations: Sequence[float]
    """Accelerations [rad/s²]."""

    @property
    def is_at_rest(self) -> bool:
        """Whether no joint moves."""
        return not any(self.velocities)

    @staticmethod
    def resting(positions: Sequence[float]) -> ArmSetpoint:
        """Return the setpoint of resting at ``positions`` [rad]."""
        zeros = (0.0,) * len(positions)
        return ArmSetpoint(tuple(positions), zeros, zeros)


Six = tuple[float, float, float, float, float, float]
"""Numbers of an arm's joints from base to flange, or a wrench: force, then torque."""


class Stall(NamedTuple):
    """A joint that is driven and has not moved for ``STALL_TIME``."""

    joint: str
    effort: float
    """Effort with which the joint pushes [N·m | N]."""
    contacts: tuple[tuple[str, str], ...] = ()
    """The links beyond the joint that touch something, and what they touch; the
    strongest contact first.  Empty if the joint is at its stop or overloaded."""
    lag: float | None = None
    """Distance from its setpoint [rad | m]; None if it pushes with its effort limit."""

    def __str__(self) -> str:
        touching = contacts_text(self.contacts)
        touching = touching or "no contact: a joint stop, or the load"
        does = f"is at its effort limit of {abs(self.effort):.4g}"
        if self.lag is not None:
            does = f"is {self.lag:.3f} from its setpoint"
        return f"joint '{self.joint}' {does} and does not move ({touching})"


MIN_SNAPSHOT_RATE, MAX_SNAPSHOT_RATE = 0.001, 500.0
"""Range of snapshot rates for subscribers, per simulated second [Hz]."""
