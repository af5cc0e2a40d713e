"""The handle that moves an arm instead of its controllers: paths, streams, forces."""

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
    """Moves an arm instead of its controllers: executes planned paths and streams.

    Take the arm first; its controllers stop, and start again when you release it.
    Joints are in the order from base to flange.  Poses are UR's: position and rotation
    vector [m, rad] in the frame of the link ``base``.
    """

    def __init__(self, arm: str, channel: Channel) -> None:
        self._arm = arm
        self._channel = channel

    @property
    def state(self) -> ArmSample:
        """Setpoint, mode, path and external wrench, as they are now."""
        return self._channel.call(ReadArmMotion(arm=self._arm))

    @contextmanager
    def taken(self, by: str = "Python") -> Iterator[ArmMotion]:
        """Take the arm for a block, and release it."""
        self.take(by)
        try:
            yield self
        finally:
            self.release()

    def take(self, by: str = "Python") -> None:
        """Stop the arm's controllers and hold still; ``by`` is shown to users.

        Raises:
            ControlError: If the arm is switched off or stopped.
        """
        self._channel.call(TakeArm(arm=self._arm, by=by))

    def release(self) -> None:
        """Stop, and start the controllers again."""
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
        """Follow a path that starts with the setpoint; return its number.

        Args:
            times: Times of the knots after the start [s].
            positions: Positions [rad], shape (n_knots, 6).
            velocities: Velocities [rad/s], the same shape; 0 at the end.
            accelerations: Accelerations [rad/s²]; with them, the path is made of
                quintics, otherwise of cubics.
            after: The number of a path that this one replaces.
            at: Time of that path from which it is replaced [s].

        Raises:
            ControlError: If the joints cannot follow it, or it does not start there.
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
        """Wait until the path has arrived at its end, or the stop has ended.

        Args:
            timeout: As for ``GoalHandle.wait`` [s].

        Raises:
            ControlError: If the motion failed, with the joint and what it touches, or
                the arm is no longer taken.
            GoalTimeoutError: If the arm still moves then.
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
        """Ramp down to rest.

        Args:
            deceleration: Deceleration of the leading joint [rad/s²]; of the path's
                speed [1/s] if the arm is to stay on its path.
            along_path: Whether the arm stays on its path.
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
        """Follow a target from now on [rad]; send the next one soon."""
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
        """Drive the joints with torques [N·m], in addition to gravity.

        Send the next ones soon; without them, the arm returns to position control.

        Args:
            torques: Torques [N·m], shape (6,).
            viscous_scale: Part of the viscous friction that is compensated, 0 … 1.
            coulomb_scale: Part of the dry friction that is compensated, 0 … 1.
            duration: Simulated time until which the next ones must come [s].

        Raises:
            ControlError: If a torque exceeds that of its drive, or the engine has no
                torque control.
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
        """Return from torques to position control."""
        self._channel.call(EndTorques(arm=self._arm))

    def speed_joints(
        self,
        velocities: Sequence[float],
        acceleration: float = 1.4,
        duration: float | None = None,
    ) -> None:
        """Ramp to joint velocities [rad/s], and to rest after ``duration`` [s]."""
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
        """Ramp to a velocity of the point ``tcp``, in the axes of the base.

        ``twist`` is [m/s, rad/s]; after ``duration`` [s] the arm ramps to rest.
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
        """Push with a force [N, N·m] along the selected axes of a frame.

        ``limits`` are the largest speeds along those, and the largest deviations along
        the others that the arm resists with more force.
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
        """Stop pushing, and stop where the arm is."""
        self._channel.call(EndForceMode(arm=self._arm))

    def start_freedrive(self, axes: Sequence[bool] = _ALL) -> None:
        """Start freedrive along these ``axes`` of the base."""
        request = StartFreedrive(arm=self._arm, axes=_six_flags(axes))
        self._channel.call(request)

    def end_freedrive(self) -> None:
        """Hold the arm where it is."""
        self._channel.call(EndFreedrive(arm=self._arm))

    def zero_wrench(self) -> None:
        """Tare the external wrench of ``state``."""
        self._channel.call(ZeroWrench(arm=self._arm))


def _six(values: Sequence[float]) -> Row6:
    return cast("Row6", values)  # the request checks it


def _six_flags(values: Sequence[bool]) -> Flags6:
    return cast("Flags6", values)
