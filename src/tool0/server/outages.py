"""Rejection of motions that peers requested while this process was frozen."""

from __future__ import annotations

import time
from typing import Any, Final, final

from tool0.errors import ControlError
from tool0.protocol.arm import MoveLinear, MoveTo
from tool0.protocol.arm_motion import (
    DriveTorques,
    ExecutePath,
    ServoJoints,
    SpeedJoints,
    SpeedTool,
    StartForceMode,
    StartFreedrive,
    TakeArm,
)
from tool0.protocol.control_box import PlayProgram
from tool0.protocol.freeze_meter import FreezeMeter
from tool0.protocol.gripper import Grip, ReactivateGripper
from tool0.protocol.motion import CommandGripper, CommandJoints, MoveJoints, SteerJoints
from tool0.protocol.objects import PullLink
from tool0.protocol.poses import GoToPose
from tool0.protocol.programs import ResumeRun, RunProgram, StepRun
from tool0.protocol.request import Request
from tool0.protocol.running import Resume, Step
from tool0.protocol.trajectories import CommandTrajectory, FollowTrajectory
from tool0.server.session import Session

READING: Final = 1.0
"""Wall time after an outage within which the messages sent during it are read [s]."""
_REPEATED: Final = 1.0
"""Minimum wall time between two equal errors that are sent to one peer for requests
without a reply [s]."""
PAUSE: Final = 0.5
"""Wall time without setpoints after which a refused stream is treated as a new stream
[s]."""
MOVING: Final = (
    CommandGripper,
    CommandJoints,
    CommandTrajectory,
    DriveTorques,
    ExecutePath,
    FollowTrajectory,
    GoToPose,
    Grip,
    MoveJoints,
    MoveLinear,
    MoveTo,
    PlayProgram,
    PullLink,
    ReactivateGripper,
    Resume,
    ResumeRun,
    RunProgram,
    ServoJoints,
    SpeedJoints,
    SpeedTool,
    StartForceMode,
    StartFreedrive,
    SteerJoints,
    Step,
    StepRun,
    TakeArm,
)
"""Requests that can cause motion.  However, ``command_trajectory`` without points is a
stop request."""


@final
class Outages:
    """The outages of this process and their effects on its connections."""

    def __init__(self) -> None:
        self._freeze: FreezeMeter | None = None
        """Meter of freezes, which is created at the first check because a server may
        wait for its first peer for a long time."""
        self._duration = 0.0
        self._until = 0.0
        self._errors: dict[Session, tuple[str, float]] = {}
        self._refused: dict[Session, float] = {}
        """Time of the last refused setpoint of a stream in each session [wall s]."""

    def look(self) -> bool:
        """Return whether the process has been frozen since the last call."""
        self._freeze = self._freeze or FreezeMeter()
        duration = self._freeze.look()
        if duration:
            self._duration = duration
            self._until = time.monotonic() + READING
        return duration > 0.0

    def refusal(
        self, session: Session, request: Request[Any], *, is_streamed: bool
    ) -> ControlError | None:
        """Return the error for a request that must not be executed, or None.

        Setpoints of a stream that continues after an outage are refused until the
        stream pauses, because the sender may not know that the robot has stopped.
        """
        if not isinstance(request, MOVING) or not (self._until or self._refused):
            return None
        if isinstance(request, CommandTrajectory) and not request.points:
            return None
        now = time.monotonic()
        continues = is_streamed and now - self._refused.get(session, -PAUSE) < PAUSE
        if now >= self._until and not continues:
            self._refused.pop(session, None)
            return None
        if is_streamed:
            self._refused[session] = now
        return ControlError(
            f"the simulator stood still for {self._duration:.1f} s, and does not carry "
            "out motions that were requested meanwhile; request them again"
        )

    def is_new(self, session: Session, message: str) -> bool:
        """Return whether an error was not sent to a peer within the last second."""
        now = time.monotonic()
        last, at = self._errors.get(session, ("", 0.0))
        if message == last and now - at < _REPEATED:
            return False
        self._errors[session] = (message, now)
        return True

    def forget(self, session: Session) -> None:
        """Discard the data about a connection that has ended."""
        self._errors.pop(session, None)
        self._refused.pop(session, None)
