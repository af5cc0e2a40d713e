"""The setpoint of a controller, as a frozen value that any thread may read."""

from __future__ import annotations

from collections.abc import Sequence
from operator import sub
from typing import NamedTuple

from tool0.control.segment import Sample, shortest_turn
from tool0.control.spline import JointSpline
from tool0.control.trajectory import JointsMotion, TrajectoryState
from tool0.description.model import Joint, JointType
from tool0.hardware.joint_state import JointSelector, JointState


class Setpoint(NamedTuple):
    """Where one controller wants its joints: at one instant, and in the end.

    A named tuple of values that do not change, since the loop makes one a hundred times
    a second.  The numbers are worked out when they are read, in the thread that reads
    them.
    """

    joint_models: tuple[Joint, ...]
    splines: tuple[JointSpline, ...]
    """One per joint; a new goal makes new ones."""
    select: JointSelector
    """Takes the joints out of the lists of ``measured``."""
    measured: JointState
    """At that instant."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of every sequence here."""
        return tuple(joint.name for joint in self.joint_models)

    def target(self) -> tuple[float, ...]:
        """Return where the joints are to end up [rad | m]."""
        return tuple(spline.target for spline in self.splines)

    def desired_and_target(self, joint: str) -> tuple[float, float] | None:
        """Return the desired position of one joint then and in the end [rad | m].

        None if it is none of these; much cheaper than ``state`` and ``target``.
        """
        for model, spline in zip(self.joint_models, self.splines, strict=True):
            if model.name == joint:
                return spline.sample(self.measured.time).position, spline.target
        return None

    def state(self) -> TrajectoryState:
        """Return desired, actual and error at that instant."""
        time, position, velocity, _ = self.measured
        section, segment, _ = self.splines[0].active(time)
        segment_start = segment.start - section.start
        since = segment_start + time - segment.start
        desired = joints_motion(
            [spline.sample(time) for spline in self.splines],
            time_from_start=segment_start,
        )
        actual = JointsMotion(
            positions=tuple(self.select(position)),
            velocities=tuple(self.select(velocity)),
            time_from_start=since,
        )
        return TrajectoryState(
            joint_names=self.joint_names,
            time=time,
            desired=desired,
            actual=actual,
            error=JointsMotion(
                positions=tuple(
                    map(_error, self.joint_models, desired.positions, actual.positions)
                ),
                velocities=tuple(map(sub, desired.velocities, actual.velocities)),
                time_from_start=desired.time_from_start - since,
            ),
        )


def _error(joint: Joint, desired: float, actual: float) -> float:
    if joint.type is JointType.CONTINUOUS:
        return shortest_turn(actual, desired)
    return desired - actual


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
