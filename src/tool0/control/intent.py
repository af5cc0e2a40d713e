"""What a controller wants of its joints, as a frozen value that any thread may ask."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from tool0.control.angles import shortest_turn
from tool0.control.track import Track, active_piece, sample_track
from tool0.control.trajectory import JointsMotion, TrajectoryState
from tool0.description.model import Joint, JointType
from tool0.hardware.joint_state import JointState
from tool0.hardware.pick import Picker


class Intent(Protocol):
    """What one controller wanted at one instant.

    Taking it costs the tick next to nothing: what it says is worked out when it is
    asked, in the thread that asks.
    """

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of every sequence here."""

    def state(self) -> TrajectoryState:
        """Return desired, actual and error at that instant."""

    def target(self) -> tuple[float, ...]:
        """Return where the joints are to end up [rad | m]."""

    def wanted(self, joint: str) -> tuple[float, float] | None:
        """Return where one joint is wanted then and in the end [rad | m].

        None if it is none of these; much cheaper than ``state`` and ``target``.
        """


class TrajectoryIntent(NamedTuple):
    """To move along tracks.  Nothing in it changes: a new goal makes new tracks.

    A named tuple, since the loop makes one a hundred times a second.
    """

    joint_models: tuple[Joint, ...]
    tracks: tuple[Track, ...]
    """One per joint."""
    pick: Picker
    """Takes the joints out of the lists of ``measured``."""
    measured: JointState

    @property
    def joint_names(self) -> tuple[str, ...]:
        return _names(self.joint_models)

    def target(self) -> tuple[float, ...]:
        """Return the positions at the end of each track."""
        ends = [track[-1].segment for track in self.tracks]
        return tuple(segment.sample(segment.end).position for segment in ends)

    def wanted(self, joint: str) -> tuple[float, float] | None:
        """Return where one joint is wanted then, and at the end of its track."""
        for model, track in zip(self.joint_models, self.tracks, strict=True):
            if model.name == joint:
                last = track[-1].segment
                now = sample_track(track, self.measured.time)
                return now.position, last.sample(last.end).position
        return None

    def state(self) -> TrajectoryState:
        """Return desired, actual and error at the time of ``measured``."""
        time = self.measured.time
        motions = [sample_track(track, time) for track in self.tracks]
        piece, _ = active_piece(self.tracks[0], time)
        return _state(
            self.joint_models,
            self.pick,
            self.measured,
            JointsMotion(
                positions=tuple(motion.position for motion in motions),
                velocities=tuple(motion.velocity for motion in motions),
                accelerations=tuple(motion.acceleration for motion in motions),
                time_from_start=piece.time_from_start,
            ),
            since=piece.time_from_start + time - piece.segment.start,
        )


class PositionIntent(NamedTuple):
    """To go somewhere at once and stay there."""

    joint_models: tuple[Joint, ...]
    positions: tuple[float, ...]
    """Where to [rad | m]."""
    pick: Picker
    """Takes the joints out of the lists of ``measured``."""
    measured: JointState

    @property
    def joint_names(self) -> tuple[str, ...]:
        return _names(self.joint_models)

    def target(self) -> tuple[float, ...]:
        return self.positions

    def wanted(self, joint: str) -> tuple[float, float] | None:
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
        return _state(self.joint_models, self.pick, self.measured, desired, since=0.0)


def _names(joints: Sequence[Joint]) -> tuple[str, ...]:
    return tuple(joint.name for joint in joints)


def _state(
    joints: Sequence[Joint],
    pick: Picker,
    measured: JointState,
    desired: JointsMotion,
    *,
    since: float,
) -> TrajectoryState:
    """Put together what is desired and what was measured.

    Args:
        joints: The joints of ``desired``.
        pick: Takes them out of ``measured``.
        measured: Every joint.
        desired: What is wanted at that instant.
        since: Time since the start of the trajectory [s].
    """
    actual, speed = tuple(pick(measured.position)), tuple(pick(measured.velocity))
    return TrajectoryState(
        joint_names=_names(joints),
        time=measured.time,
        desired=desired,
        actual=JointsMotion(positions=actual, velocities=speed, time_from_start=since),
        error=JointsMotion(
            positions=tuple(
                shortest_turn(q, wanted)
                if joint.type is JointType.CONTINUOUS
                else wanted - q
                for joint, wanted, q in zip(
                    joints, desired.positions, actual, strict=True
                )
            ),
            velocities=tuple(
                wanted - qd
                for wanted, qd in zip(desired.velocities, speed, strict=True)
            ),
            time_from_start=desired.time_from_start - since,
        ),
    )
