"""The whole robot at one instant, as a frozen value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, final

from tool0.control.manager import ControllerStatus
from tool0.control.trajectory import Setpoint
from tool0.description.scene import SceneObject
from tool0.hardware.engine import ObjectState

SNAPSHOT_PERIOD = 0.008
"""Default simulated time between snapshots [s]: 125 Hz, the rate of the UR's own
reports."""


class JointSetpoint(NamedTuple):
    """What a controller wants of one joint."""

    position: float
    """At this instant [rad | m]."""
    velocity: float
    """At this instant [rad/s | m/s]."""
    target: float
    """Where the motion ends [rad | m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The whole robot at one instant.

    ``position``, ``velocity`` and ``effort`` have shape (n_joints,), ordered as
    ``joint_names``: [rad | m], [rad/s | m/s], [N·m | N].
    """

    time: float
    """Simulated time [s]."""
    tick: int
    joint_names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]
    controllers: tuple[ControllerStatus, ...]
    is_paused: bool
    is_stopped: bool
    """Whether the emergency stop is engaged."""
    real_time_factor: float
    """Simulated per wall second, over about the last second."""
    overruns: int
    """Ticks that began more than one control period late, since the start."""
    fault: str | None = None
    """Why the simulation stands still, until it is reset."""
    speed: float | None = None
    """Requested simulated seconds per wall second; None runs only on request, as fast
    as possible."""
    controller_setpoints: Mapping[str, Setpoint] = field(default_factory=dict)
    """What each running controller wants of its joints; empty in another process."""
    received_setpoints: Mapping[str, JointSetpoint] = field(default_factory=dict)
    """Joint → setpoint, where another process worked them out."""
    scene: tuple[SceneObject, ...] = ()
    """The objects around the robot: the same tuple until one is added or removed."""
    objects: tuple[ObjectState, ...] = ()
    """Poses and velocities of the objects, in the order of ``scene``."""

    @property
    def positions(self) -> dict[str, float]:
        """Joint → position [rad | m]."""
        return dict(zip(self.joint_names, self.position, strict=True))

    def setpoints(self) -> Mapping[str, JointSetpoint]:
        """Return the setpoint of each joint that a controller moves by position.

        It is worked out here, in the thread of the reader.
        """
        if not self.controller_setpoints:
            return self.received_setpoints
        found: dict[str, JointSetpoint] = {}
        for setpoint in self.controller_setpoints.values():
            time = setpoint.measured.time
            for joint, spline in zip(
                setpoint.joint_models, setpoint.splines, strict=True
            ):
                now = spline.sample(time)
                found[joint.name] = JointSetpoint(
                    now.position, now.velocity, spline.target
                )
        return found

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return where one joint is wanted now and in the end [rad | m].

        None if no controller moves it by position.  Much cheaper than ``setpoints``.
        """
        for setpoint in self.controller_setpoints.values():
            wanted = setpoint.desired_and_target(joint)
            if wanted is not None:
                return wanted
        received = self.received_setpoints.get(joint)
        return None if received is None else (received.position, received.target)
