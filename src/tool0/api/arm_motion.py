"""Handle that moves an arm in place of its controllers: paths, streams, forces."""

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
    """Moves an arm in place of its controllers: along paths, by streams or by forces.

    Take the arm first; its controllers stop, and start again when you release it.
    Joints are in the order from base to flange.  Poses use UR's notation: position and
    rotation vector [m, rad] in the frame of the link ``base``.
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
        """Stop the arm's controllers and hold still; ``by`` is shown to users.

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
        """Follow a path that starts at the current setpoint; return the path's number.

        Args:
            times: Time of each knot after the start of the path [s].
            positions: Positions [rad], shape (n_knots, 6).
            velocities: Velocities [rad/s], the same shape; 0 at the end.
            accelerations: Accelerations [rad/s²], the same shape; with them, segments
                are quintic polynomials, otherwise cubic ones.
            after: The number of a path that this one replaces.
            at: Time on the replaced path at which this one takes over [s].

        Raises:
            ControlError: If the joints cannot follow the path, or it does not start at
                the setpoint.
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
        """Wait until the path has reached its end, or the arm has stopped.

        Args:
            timeout: Longest wait [s]; see ``GoalHandle.wait``.

        Raises:
            ControlError: If the motion failed (the message names the joint and what it
                touches), or if the arm is no longer taken.
            GoalTimeoutError: If the arm still moves after ``timeout``.
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
                ``along_path``, that of the speed along the path [1/s].
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
        """Follow a joint target [rad] from now on; send new targets regularly."""
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

        Send new torques within ``duration``; otherwise, the arm returns to position
        control.

        Args:
            torques: Torques [N·m], shape (6,).
            viscous_scale: Fraction of the viscous friction that is compensated, 0 … 1.
            coulomb_scale: Fraction of the dry friction that is compensated, 0 … 1.
            duration: Simulated time within which the next torques must arrive [s].

        Raises:
            ControlError: If a torque exceeds its drive's limit, or the engine has no
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
        """Ramp to a velocity of the point ``tcp``, given in the base's axes.

        ``twist`` is the linear and angular velocity [m/s, rad/s]; after ``duration``
        [s], the arm ramps to rest.
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
        """Push with a force and torque [N, N·m] along the selected axes of a frame.

        Along the selected axes, ``limits`` are the largest speeds [m/s, rad/s]; along
        the others, the largest deviations [m, rad], which the arm resists with more
        force.
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
        """End force mode, and hold the arm where it is."""
        self._channel.call(EndForceMode(arm=self._arm))

    def start_freedrive(self, axes: Sequence[bool] = _ALL) -> None:
        """Start freedrive along and about the selected ``axes`` of the base."""
        request = StartFreedrive(arm=self._arm, axes=_six_flags(axes))
        self._channel.call(request)

    def end_freedrive(self) -> None:
        """End freedrive, and hold the arm where it is."""
        self._channel.call(EndFreedrive(arm=self._arm))

    def zero_wrench(self) -> None:
        """Tare the external wrench of ``state``."""
        self._channel.call(ZeroWrench(arm=self._arm))


def _six(values: Sequence[float]) -> Row6:
    return cast("Row6", values)  # the request checks it


def _six_flags(values: Sequence[bool]) -> Flags6:
    return cast("Flags6", values)
