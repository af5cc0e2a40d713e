"""The setpoint of a controller, as a frozen value that any thread may read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from tool0.control.segment import Sample, shortest_turn
from tool0.control.spline import JointSpline
from tool0.control.trajectory import JointsMotion, TrajectoryState
from tool0.description.model import Joint, JointType
from tool0.hardware.joint_state import JointSelector, JointState


class Setpoint(Protocol):
    """Where one controller wants its joints: at one instant, and in the end.

    The tick only makes the value, at next to no cost.  The numbers are worked out when
    they are read, in the thread that reads them.
    """

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of every sequence here."""

    def state(self) -> TrajectoryState:
        """Return desired, actual and error at that instant."""

    def target(self) -> tuple[float, ...]:
        """Return where the joints are to end up [rad | m]."""

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the desired position of one joint then and in the end [rad | m].

        None if it is none of these; much cheaper than ``state`` and ``target``.
        """


class TrajectorySetpoint(NamedTuple):
    """To move along splines.  Nothing in it changes: a new goal makes new splines.

    A named tuple, since the loop makes one a hundred times a second.
    """

    joint_models: tuple[Joint, ...]
    splines: tuple[JointSpline, ...]
    """One per joint."""
    select: JointSelector
    """Takes the joints out of the lists of ``measured``."""
    measured: JointState

    @property
    def joint_names(self) -> tuple[str, ...]:
        return _names(self.joint_models)

    def target(self) -> tuple[float, ...]:
        """Return the positions at the end of each spline."""
        return tuple(spline.target for spline in self.splines)

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the position of one joint on its spline then, and at the end."""
        for model, spline in zip(self.joint_models, self.splines, strict=True):
            if model.name == joint:
                return spline.sample(self.measured.time).position, spline.target
        return None

    def state(self) -> TrajectoryState:
        """Return desired, actual and error at the time of ``measured``."""
        time = self.measured.time
        samples = [spline.sample(time) for spline in self.splines]
        section, segment, _ = self.splines[0].active(time)
        segment_start = segment.start - section.start
        return _state(
            self.joint_models,
            self.select,
            self.measured,
            joints_motion(samples, time_from_start=segment_start),
            since=segment_start + time - segment.start,
        )


class PositionSetpoint(NamedTuple):
    """To go somewhere at once and stay there."""

    joint_models: tuple[Joint, ...]
    positions: tuple[float, ...]
    """Where to [rad | m]."""
    select: JointSelector
    """Takes the joints out of the lists of ``measured``."""
    measured: JointState

    @property
    def joint_names(self) -> tuple[str, ...]:
        return _names(self.joint_models)

    def target(self) -> tuple[float, ...]:
        return self.positions

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return where one joint is to go, twice."""
        for model, position in zip(self.joint_models, self.positions, strict=True):
            if model.name == joint:
                return position, position
        return None

    def state(self) -> TrajectoryState:
        """Return the positions, at rest, as what is desired."""
        rest = (0.0,) * len(self.positions)
        desired = JointsMotion(
            positions=self.positions, velocities=rest, accelerations=rest
        )
        return _state(self.joint_models, self.select, self.measured, desired, since=0.0)


def joints_motion(
    samples: Sequence[Sample], *, time_from_start: float = 0.0
) -> JointsMotion:
    """Return the samples of several joints as one motion."""
    return JointsMotion(
        positions=tuple(sample.position for sample in samples),
        velocities=tuple(sample.velocity for sample in samples),
        accelerations=tuple(sample.acceleration for sample in samples),
        time_from_start=time_from_start,
    )


def _names(joints: Sequence[Joint]) -> tuple[str, ...]:
    return tuple(joint.name for joint in joints)


def _state(
    joints: Sequence[Joint],
    select: JointSelector,
    measured: JointState,
    desired: JointsMotion,
    *,
    since: float,
) -> TrajectoryState:
    """Put together what is desired and what was measured.

    Args:
        joints: The joints of ``desired``.
        select: Takes them out of ``measured``.
        measured: Every joint.
        desired: Desired motion at that instant.
        since: Time since the start of the trajectory [s].
    """
    actual, speed = tuple(select(measured.position)), tuple(select(measured.velocity))
    return TrajectoryState(
        joint_names=_names(joints),
        time=measured.time,
        desired=desired,
        actual=JointsMotion(positions=actual, velocities=speed, time_from_start=since),
        error=JointsMotion(
            positions=tuple(
                shortest_turn(q, q_des)
                if joint.type is JointType.CONTINUOUS
                else q_des - q
                for joint, q_des, q in zip(
                    joints, desired.positions, actual, strict=True
                )
            ),
            velocities=tuple(
                qd_des - qd
                for qd_des, qd in zip(desired.velocities, speed, strict=True)
            ),
            time_from_start=desired.time_from_start - since,
        ),
    )
