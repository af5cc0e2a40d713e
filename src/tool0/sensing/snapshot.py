"""The whole robot at one instant, as a frozen value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, final

from msgspec import Struct, field

from tool0.control.arm_setpoint import ArmSetpoint
from tool0.control.status import ControllerStatus
from tool0.control.trajectory import Setpoint
from tool0.description.scene import SceneObject
from tool0.hardware.control_box import ControlBoxState
from tool0.hardware.engine import Contact, ObjectState
from tool0.hardware.tool_dynamics import Wrench
from tool0.sensing.stalls import Stall

MotionMode = Literal["free", "hold", "path", "servo", "speed", "stop", "freedrive"]
"""What moves an arm: ``free`` is a controller of ROS, or nothing."""

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
    """At this instant [rad | m]."""
    velocity: float
    """At this instant [rad/s | m/s]."""
    target: float
    """The end of the motion [rad | m]."""


@final
class ArmSample(Struct, frozen=True):
    """What moves an arm, and what pushes its tool."""

    joint_names: tuple[str, ...]
    """From base to flange."""
    mode: MotionMode
    setpoint: ArmSetpoint | None
    """Of a stream; otherwise a controller's setpoint has it."""
    path: int
    """Number of the last path; 0 before the first."""
    path_time: float
    """On that path [s]."""
    is_done: bool
    """Whether the path has arrived at its end, or the stop has ended."""
    force_mode: bool
    wrench: Wrench
    """At the flange, in its axes [N, N·m], less payload and tare."""
    failure: str = ""
    """Why the motion failed; empty if it did not."""


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
    """Measured [rad | m], shape (n_joints,)."""
    velocity: tuple[float, ...]
    """Measured [rad/s | m/s], shape (n_joints,)."""
    effort: tuple[float, ...]
    """Applied during the last step [N·m | N], shape (n_joints,)."""
    controllers: tuple[ControllerStatus, ...]
    """Every loaded controller."""
    is_paused: bool
    """Whether simulated time is held."""
    is_stopped: bool
    """Whether the emergency stop is engaged."""
    real_time_factor: float
    """Simulated time per wall time, over about the last second."""
    overruns: int
    """Ticks that began more than one control period late, since the start."""
    late_ticks: int = 0
    """The same, in about the last second of wall time."""
    fault: str | None = None
    """Why the simulation has stopped, until a reset."""
    speed: float | None = None
    """Requested simulated time per wall time; None if time passes only on request, as
    fast as possible."""
    controller_setpoints: Mapping[str, Setpoint] = field(default_factory=dict)
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
    """What touches what, with forces; empty unless a subscriber needs it."""
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
            time = setpoint.time
            for joint, spline in zip(
                setpoint.joint_models, setpoint.splines, strict=True
            ):
                now = spline.sample(time)
                found[joint.name] = JointSetpoint(
                    now.position, now.velocity, spline.target
                )
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
