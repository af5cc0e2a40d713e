"""Handle that moves an arm without controllers: by paths, streams or forces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Literal, cast, final

from tool0.api.controller import checked_timeout
from tool0.errors import ControlError, GoalTimeoutError
from tool0.protocol.arm_motion import (
    COULOMB_SCALE,
    VISCOUS_SCALE,
    DriveTorques,
    EndForceMode,
    EndFreedrive,
    EndTorques,
    ExecutePath,
    Flags6,
    ReadArmMotion,
    ReturnArm,
    Row6,
    Rows6,
    ServoJoints,
    SpeedJoints,
    SpeedTool,
    StartForceMode,
    StartFreedrive,
    StopArm,
    TakeArm,
    ZeroWrench,
)
from tool0.protocol.channel import Channel
from tool0.protocol.state import ArmSample

Rows = Sequence[Sequence[float]]
_NO_POSE = (0.0,) * 6
_ALL = (True,) * 6


@final
class ArmMotion:
    """Moves an arm without controllers: along paths, with streams, or by forces.

    Call ``take`` first; it stops the arm's controllers.  When you release the arm, its
    controllers are started again.  Joints are ordered from base to flange.  Poses use
    UR's notation: position and rotation vector [m, rad] in the frame of the link
    ``base``.
    """

    def __init__(self, arm: str, channel: Channel) -> None:
        self._arm = arm
        self._channel = channel

    @property
    def state(self) -> ArmSample:
        """Current setpoint, mode, path and external wrench."""
        return self._channel.call(ReadArmMotion(arm=self._arm))

    @contextmanager
    def taken(self, by: str = "Python") -> Iterator[ArmMotion]:
        """Take the arm for a ``with`` block, and release it at the end."""
        self.take(by)
        try:
            yield self
        finally:
            self.release()

    def take(self, by: str = "Python") -> None:
        """Stop the arm's controllers, and hold the position; ``by`` is shown to users.

        Raises:
            ControlError: If the arm is switched off or stopped.
        """
        self._channel.call(TakeArm(arm=self._arm, by=by))

    def release(self) -> None:
        """Stop the arm, and start its controllers again."""
        self._channel.call(ReturnArm(arm=self._arm))

    def execute_path(
        self,
        times: Sequence[float],
        positions: Rows,
        velocities: Rows,
        accelerations: Rows = (),
        *,
        after: int | None = None,
        at: float | None = None,
    ) -> int:
        """Follow a path that starts at the current setpoint; return the path number.

        Args:
            times: Time of each knot after the start of the path [s].
            positions: Positions [rad], shape (n_knots, 6).
            velocities: Velocities [rad/s], shape (n_knots, 6); 0 at the last knot.
            accelerations: Accelerations [rad/s²], shape (n_knots, 6).  With
                accelerations, the segments are quintic polynomials; otherwise, they are
                cubic polynomials.
            after: Number of the path that this path replaces.
            at: Time on the replaced path at which this path begins [s].

        Raises:
            ControlError: If the joints cannot follow the path, or if the path does not
                start at the setpoint.
        """
        request = ExecutePath(
            arm=self._arm,
            times=cast("tuple[float, ...]", times),
            positions=cast("Rows6", positions),
            velocities=cast("Rows6", velocities),
            accelerations=cast("Rows6", accelerations),
            after=after,
            at=at,
        )
        return self._channel.call(request)

    def wait(self, timeout: float | None = None) -> None:
        """Wait until the path has ended, or until the arm has stopped.

        Args:
            timeout: Longest wait [s]; see ``GoalHandle.wait``.

        Raises:
            ControlError: If the motion failed (the message contains the joint and the
                touched body), or if the arm is no longer taken.
            GoalTimeoutError: If the arm is still moving after ``timeout``.
        """
        state = self.state

        def is_over() -> bool:
            nonlocal state
            state = self.state
            return state.is_done or bool(state.failure)

        is_in_time = self._channel.wait_until(is_over, checked_timeout(timeout))
        if state.failure:
            raise ControlError(f"the motion failed: {state.failure}")
        if state.mode == "free":
            raise ControlError(
                f"the arm '{self._arm}' is not taken: it was released or stopped"
            )
        if not is_in_time:
            raise GoalTimeoutError(f"the arm still moves after {timeout} s")

    def stop(self, deceleration: float = 2.0, *, along_path: bool = False) -> None:
        """Decelerate to rest.

        Args:
            deceleration: Deceleration of the leading joint [rad/s²]; with
                ``along_path``, deceleration of the path's speed [1/s].
            along_path: Whether the arm stays on its path during the deceleration.
        """
        self._channel.call(
            StopArm(arm=self._arm, deceleration=deceleration, along_path=along_path)
        )

    def servo_joints(
        self,
        positions: Sequence[float],
        *,
        lookahead_time: float = 0.1,
        gain: float = 300.0,
    ) -> None:
        """Follow a joint target [rad]; send new targets regularly."""
        self._channel.call(
            ServoJoints(
                arm=self._arm,
                positions=_six(positions),
                lookahead_time=lookahead_time,
                gain=gain,
            )
        )

    def drive_torques(
        self,
        torques: Sequence[float],
        *,
        viscous_scale: Sequence[float] = VISCOUS_SCALE,
        coulomb_scale: Sequence[float] = COULOMB_SCALE,
        duration: float = 0.02,
    ) -> None:
        """Apply torques [N·m] to the joints, in addition to gravity compensation.

        Send new torques within ``duration``.  Otherwise, the arm returns to position
        control.

        Args:
            torques: Torques of the joints [N·m], shape (6,).
            viscous_scale: Compensated fraction of each joint's viscous friction, 0 … 1.
            coulomb_scale: Compensated fraction of each joint's dry friction, 0 … 1.
            duration: Simulated time within which the next torques must be received [s].

        Raises:
            ControlError: If a torque exceeds the limit of its drive, or if the engine
                has no torque control.
        """
        self._channel.call(
            DriveTorques(
                arm=self._arm,
                torques=_six(torques),
                viscous_scale=_six(viscous_scale),
                coulomb_scale=_six(coulomb_scale),
                duration=duration,
            )
        )

    def end_torques(self) -> None:
        """Return from torque control to position control."""
        self._channel.call(EndTorques(arm=self._arm))

    def speed_joints(
        self,
        velocities: Sequence[float],
        acceleration: float = 1.4,
        duration: float | None = None,
    ) -> None:
        """Accelerate to joint velocities [rad/s], and stop after ``duration`` [s]."""
        self._channel.call(
            SpeedJoints(
                arm=self._arm,
                velocities=_six(velocities),
                acceleration=acceleration,
                duration=duration,
            )
        )

    def speed_tool(
        self,
        twist: Sequence[float],
        acceleration: float = 1.2,
        duration: float | None = None,
        *,
        tcp: Sequence[float] = _NO_POSE,
    ) -> None:
        """Accelerate the point ``tcp`` to a velocity, given in the axes of the base.

        ``twist`` is the linear and angular velocity [m/s, rad/s].  After ``duration``
        [s], the arm decelerates to rest.
        """
        self._channel.call(
            SpeedTool(
                arm=self._arm,
                twist=_six(twist),
                acceleration=acceleration,
                duration=duration,
                tcp=_six(tcp),
            )
        )

    def start_force_mode(
        self,
        wrench: Sequence[float],
        selection: Sequence[bool],
        *,
        limits: Sequence[float] = (0.1, 0.1, 0.1, 0.5, 0.5, 0.5),
        frame: Sequence[float] = _NO_POSE,
        kind: Literal[1, 2, 3] = 2,
        tcp: Sequence[float] = _NO_POSE,
    ) -> None:
        """Apply a force and torque [N, N·m] along the selected axes of a frame.

        Along the selected axes, ``limits`` are the maximum speeds [m/s, rad/s].  Along
        the other axes, ``limits`` are the deviations [m, rad] at which the restoring
        force stops increasing.
        """
        self._channel.call(
            StartForceMode(
                arm=self._arm,
                frame=_six(frame),
                selection=_six_flags(selection),
                wrench=_six(wrench),
                limits=_six(limits),
                kind=kind,
                tcp=_six(tcp),
            )
        )

    def end_force_mode(self) -> None:
        """End force mode, and hold the arm at its present position."""
        self._channel.call(EndForceMode(arm=self._arm))

    def start_freedrive(self, axes: Sequence[bool] = _ALL) -> None:
        """Start freedrive along and about the selected ``axes`` of the base."""
        request = StartFreedrive(arm=self._arm, axes=_six_flags(axes))
        self._channel.call(request)

    def end_freedrive(self) -> None:
        """End freedrive, and hold the arm at its present position."""
        self._channel.call(EndFreedrive(arm=self._arm))

    def zero_wrench(self) -> None:
        """Tare the external wrench of ``state``."""
        self._channel.call(ZeroWrench(arm=self._arm))


def _six(values: Sequence[float]) -> Row6:
    return cast("Row6", values)  # the request checks the values


def _six_flags(values: Sequence[bool]) -> Flags6:
    return cast("Flags6", values)
