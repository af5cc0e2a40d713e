"""The PIDs of ros_controllers' JointPositionController and JointVelocityController."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from typing import final

from tool0.control.angles import shortest_turn
from tool0.control.pid import Gains, Pid
from tool0.description.model import Joint, JointType
from tool0.hardware.joint_state import JointState
from tool0.hardware.pick import picker


class Quantity(enum.Enum):
    """What a command to a joint prescribes."""

    EFFORT = "effort"
    POSITION = "position"
    VELOCITY = "velocity"


@final
class JointServo:
    """Follow positions or velocities, with the rate from the last two errors.

    The error of a continuous joint goes the shortest way round.  That of a revolute
    joint is the plain difference: positions are continuous, and a way that leaves the
    limits is none.
    """

    def __init__(
        self,
        quantity: Quantity,
        joints: Sequence[Joint],
        gains: Sequence[Gains],
        indices: Sequence[int],
    ) -> None:
        self._follows_position = quantity is Quantity.POSITION
        self._joints = tuple(joints)
        self._pids = [Pid(item) for item in gains]
        self._pick = picker(indices)

    def within_limits(self, command: Sequence[float]) -> list[float]:
        """Return the allowed command nearest to ``command``."""
        if not self._follows_position:
            return list(command)
        return [
            value if joint.type is JointType.CONTINUOUS else joint.limits.clamp(value)
            for joint, value in zip(self._joints, command, strict=True)
        ]

    def update(
        self, command: Sequence[float], state: JointState, period: float
    ) -> list[float]:
        """Return an output per joint."""
        measured = self._pick(
            state.position if self._follows_position else state.velocity
        )
        return [
            pid.update_from_error(self._error(joint, wanted, actual), period)
            for pid, joint, wanted, actual in zip(
                self._pids, self._joints, command, measured, strict=True
            )
        ]

    def _error(self, joint: Joint, wanted: float, actual: float) -> float:
        if self._follows_position and joint.type is JointType.CONTINUOUS:
            return shortest_turn(actual, wanted)
        return wanted - actual
