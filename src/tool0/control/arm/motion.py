"""ArmMotionController: moves an arm for external motion planners.

A single setpoint with position, velocity and acceleration remains continuous across the
modes: a path, a stream of targets (servo), a stream of velocities, a ramp to rest, or
holding a position.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, Literal, final

from tool0.control.arm.compliance import Compliance, ComplianceTask
from tool0.control.arm.model import ArmModel
from tool0.control.arm.path import CONTINUITY, ArmPath, SplineMotion
from tool0.control.arm.stream import ServoStream, SpeedStream, StreamedMotion
from tool0.control.arm.torque import TorqueCommand, TorqueMode
from tool0.control.law import TrajectoryLaw
from tool0.control.spline import JointSpline, Segment, along
from tool0.control.trajectory import Setpoint
from tool0.description.model import Interface, Joint
from tool0.errors import ControlError
from tool0.hardware.engine import JointState, joint_selector
from tool0.hardware.robot_hardware import EffortLaw
from tool0.protocol.controllers import Gains
from tool0.protocol.state import ArmSetpoint

Mode = Literal["hold", "path", "servo", "speed", "stop", "freedrive", "torque"]


MOST_SAG: Final = 0.05
"""Largest deviation of a joint at rest from its setpoint [rad]."""
ARRIVED: Final = 0.01
"""Distance from the end of a path within which a joint is considered to have arrived
[rad].  Measurements with a UR3e, a UR5e and a UR30 showed an error of 1.6 mrad at the
end of a path, and of up to 0.1 rad if the declared payload was wrong (0 instead of the
rated payload, or vice versa)."""
STEEPEST: Final = 1000.0
"""Largest deceleration of the leading joint that is used to keep a joint within its
range [rad/s²].  Requests with a larger deceleration are rejected."""
SETTLING: Final = 1.0
"""Time that the joints may take to arrive at the end of a path after the setpoint has
reached the end [s].  In the measurements for ``ARRIVED``, the error after half of the
settling time was 17 mrad; the integral terms of the servos decay as exp(-4 t)."""


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ArmMotionSpec:
    """The parameters of an ArmMotionController."""

    name: str
    joint_models: tuple[Joint, ...]
    """Joints of the arm, from the base to the flange."""
    speed_scaling: Callable[[], float]
    """Function that returns the control box's speed factor, 0 … 1."""
    model: ArmModel

    type: ClassVar[str] = "tool0/ArmMotionController"
    interface: ClassVar[Interface] = Interface.POSITION
    gains: ClassVar[tuple[Gains, ...]] = ()
    further_interfaces: ClassVar[tuple[str, ...]] = ()
    state_interfaces: ClassVar[tuple[str, ...]] = ()
    waits_for_command: ClassVar[bool] = False

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joint_models)

    def start(self, indices: Sequence[int], state: JointState) -> ArmMotionController:
        return ArmMotionController(self, indices, state)


@final
class ArmMotionController:
    """Commands, in each tick, an arm's joint positions for the end of the tick.

    Requests are handled between ticks; the argument ``now`` of a request is the
    simulated time of the next tick [s].  Holding, paths and ramps to rest have a law,
    so the kernel can execute them.  Streams have no law and are executed in Python.
    """

    pid: ClassVar[None] = None

    def __init__(
        self, spec: ArmMotionSpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._indices = tuple(indices)
        self._select = joint_selector(indices)
        self._state = state
        self._period = 0.0
        self._splines = SplineMotion.holding(self._select(state.position), state.time)
        self._stream: StreamedMotion | None = None
        """Stream that moves the arm instead of the splines; None if the splines move
        it."""
        self._stream_mode: Mode = "servo"
        self._compliance: Compliance | None = None
        """Law that converts the motion to efforts in each physics step; None if the arm
        is not compliant."""
        self.torques: TorqueMode | None = None
        """Law for the torques of a program, which overrides the stream, the splines and
        the compliance; None outside of torque mode."""
        self._no_efforts = (0.0,) * len(indices)
        self._last: tuple[int, float] = (0, 0.0)
        """Number of the last path, and the time along this path when the arm left it
        [s]."""
        self._has_arrived = False
        """Whether a check has found the joints at the end of the path."""
        self._ended: float | None = None
        """Time of the first check after the end of the path was commanded [s]."""

    def rest_at(self, positions: Sequence[float], now: float) -> None:
        """Hold ``positions`` [rad] if the arm is near these positions."""
        if self._is_near(positions):
            self._splines = SplineMotion.holding(positions, now)

    def at_rest(self, state: JointState) -> JointState:
        """Return a state with the joints at their commanded positions.

        If the joints are not near the commanded positions, the state is returned
        unchanged.
        """
        positions = self.motion(state.time).positions
        if not self._is_near(positions):
            return state
        changed = list(state.position)
        for index, position in zip(self._indices, positions, strict=True):
            changed[index] = position
        return state._replace(position=changed)

    def _is_near(self, positions: Sequence[float]) -> bool:
        return self._distance(positions) < MOST_SAG

    def _distance(self, positions: Sequence[float]) -> float:
        """Return the largest deviation of a joint from ``positions`` [rad]."""
        measured = self._select(self._state.position)
        return max(abs(q - p) for q, p in zip(positions, measured, strict=True))

    # ---- the tick -----------------------------------------------------------------

    def update(self, state: JointState, period: float) -> Sequence[float]:
        self._state, self._period = state, period
        if self.torques is not None:
            return self._no_efforts
        compliance = self._compliance
        if compliance is None:
            return self._positions(state, period)
        compliance.follow(self._nominal(state.time), state.time)
        self._positions(state, period)
        return self._no_efforts

    def _positions(self, state: JointState, period: float) -> Sequence[float]:
        """Return the nominal positions at the end of a tick."""
        factor, stream = self.spec.speed_scaling(), self._stream
        if stream is not None:
            stream.advance(state.time, period, factor)
            return stream.setpoint.positions
        splines = self._splines
        command = splines.update(state.time, period, factor)
        if splines.has_braked:
            self._leave_path(state.time)
            self._splines = SplineMotion.holding(command, state.time)
        return command

    def law(self) -> TrajectoryLaw | None:
        if self._stream is not None or self.is_compliant or not self._period:
            return None
        return self._splines.law(self._period, self.spec.speed_scaling())

    def observe(self, state: JointState) -> None:
        self._state = state

    def setpoint(self) -> Setpoint:
        stream, splines = self._stream, self._splines
        joints, state = self.spec.joint_models, self._state
        if stream is None and not self.is_compliant:
            return Setpoint(
                joints,
                splines.splines,
                self._select,
                state,
                splines.lag(state.time),
                splines.speed_scaling,
            )
        now = self._measured()
        if stream is not None and not self.is_compliant:
            now = stream.setpoint
        return Setpoint(joints, _tangents(now, state.time), self._select, state)

    def stop(self) -> None:
        pass

    # ---- requests, between ticks --------------------------------------------------

    @property
    def mode(self) -> Mode:
        """The current mode."""
        if self.torques is not None:
            return "torque"
        if self.is_guided:
            return "freedrive"
        return self._splines.mode if self._stream is None else self._stream_mode

    @property
    def is_guided(self) -> bool:
        """Whether the arm is in freedrive."""
        return self._compliance is not None and self._compliance.task.is_freedrive

    @property
    def is_in_force_mode(self) -> bool:
        """Whether the arm is in force mode."""
        return self._compliance is not None and not self.is_guided

    @property
    def is_compliant(self) -> bool:
        """Whether forces or torques, rather than the setpoint, move the joints."""
        return self._compliance is not None or self.torques is not None

    def motion(self, now: float) -> ArmSetpoint:
        """Return the setpoint at ``now`` [s].

        In force mode, the result is the nominal setpoint, without the effect of forces.
        In freedrive and in torque mode, the result is the measured motion.
        """
        has_none = self.is_guided or self.torques is not None
        return self._measured() if has_none else self._nominal(now)

    def _nominal(self, now: float) -> ArmSetpoint:
        stream = self._stream
        return self._splines.setpoint(now) if stream is None else stream.setpoint

    def _measured(self) -> ArmSetpoint:
        state = self._state
        position = tuple(self._select(state.position))
        zeros = (0.0,) * len(position)
        return ArmSetpoint(position, tuple(self._select(state.velocity)), zeros)

    def unknown_setpoint(self, now: float) -> ArmSetpoint | None:
        """Return the setpoint at ``now`` [s], or None if ``setpoint()`` provides it."""
        if self._stream is None and not self.is_compliant:
            return None
        return self.motion(now)

    def is_done(self, now: float) -> bool:
        """Return whether the arm has reached the end of a path or of a ramp to rest."""
        is_moved = self.mode in {"servo", "speed", "freedrive", "torque"}
        return not is_moved and self._splines.is_done(now) and self._is_there(now)

    def _is_there(self, now: float) -> bool:
        """Return whether the joints have reached the end of the path.

        The result is also true if the arm does not have to reach the end of a path.
        """
        if self._has_arrived or not self._must_arrive:
            return True
        wanted = self._splines.setpoint(now).positions
        return self._distance(wanted) <= ARRIVED

    @property
    def _must_arrive(self) -> bool:
        is_on_path = self._splines.mode == "path" and not self._splines.has_braked
        return is_on_path and self._stream is None and not self.is_compliant

    def is_overdue(self, distance: float, now: float) -> bool:
        """Return whether the joints have failed to reach the end of a path in time.

        The supervisor of the motion calls ``is_overdue`` at regular intervals, with the
        largest ``distance`` of a joint from its setpoint [rad].
        """
        if self._has_arrived or self._splines.mode != "path":
            return False
        if not (self._must_arrive and self._splines.is_done(now)):
            return False
        if distance <= ARRIVED:
            self._has_arrived = True
            return False
        if self._ended is None:
            self._ended = now
        return not now - self._ended < SETTLING

    def progress(self, now: float) -> tuple[int, float]:
        """Return the number of the last path, and the time along the path [s]."""
        progress = None if self._stream is not None else self._splines.progress(now)
        return self._last if progress is None else progress

    def execute(self, path: ArmPath, number: int, now: float) -> None:
        """Follow a path that starts at ``now`` [s].

        Raises:
            ControlError: If the path does not begin with the setpoint.
        """
        factor = self.spec.speed_scaling()
        start = self.motion(now)
        self._use(SplineMotion.along(path, number, start, now, factor), now)

    def replace(
        self, path: ArmPath, number: int, *, after: int, at: float, now: float
    ) -> None:
        """Replace path number ``after``, starting at the time ``at`` along it [s].

        Raises:
            ControlError: If the path cannot be replaced; in this case, nothing changes.
        """
        if self._stream is not None:
            raise ControlError(
                f"path {after} is not executed, so none can follow it: the arm is in "
                f"mode '{self._stream_mode}'"
            )
        self._splines.replaced(path, number, after=after, at=at, now=now)
        self._has_arrived, self._ended = False, None

    def stop_motion(self, deceleration: float, now: float, *, along_path: bool) -> None:
        """Ramp down to rest from any mode.

        Args:
            deceleration: Deceleration of the leading joint [rad/s²], or of the path's
                clock [1/s] if the arm stays on the path.
            now: Current time [s].
            along_path: Whether the arm stays on its path if it follows a path.
        """
        splines = self._splines
        if along_path and self._stream is None and splines.mode == "path":
            if splines.is_done(now):
                self.hold(now)
            else:
                splines.brake(deceleration)
            return
        self._stop_from(self.motion(now), now, deceleration)

    def _stop_from(self, start: ArmSetpoint, now: float, deceleration: float) -> None:
        """Ramp down to rest.

        The deceleration is increased if a joint would leave its range.
        """
        leading = max(map(abs, start.velocities))
        joints = self.spec.joint_models
        for joint, q, v in zip(joints, start.positions, start.velocities, strict=True):
            left = joint.limits.upper - q if v > 0.0 else q - joint.limits.lower
            way = 0.5 * leading * abs(v)  # for a deceleration of 1
            if way > left * deceleration:
                needed = way / left if left > way / STEEPEST else STEEPEST
                deceleration = max(deceleration, needed)
        self._use(SplineMotion.stopping(start, now, deceleration), now)

    def stream_deceleration(self) -> float:
        """Return the deceleration at the end of a stream of velocities [rad/s²].

        The result is the deceleration of the leading joint, or 0 if there is no stream
        of velocities.
        """
        stream = self._stream
        return stream.deceleration() if isinstance(stream, SpeedStream) else 0.0

    def hold(self, now: float) -> None:
        """Hold the setpoint, which must be at rest."""
        self._use(SplineMotion.holding(self.motion(now).positions, now), now)

    def require_positions(self, positions: Sequence[float], now: float) -> None:
        """Raise ControlError if a position is beyond its joint's limits [rad].

        ``now`` is the time at which the motion to ``positions`` starts [s].
        """
        starts = self.motion(now).positions
        measured = self._select(self._state.position)
        for joint, q, *places in zip(
            self.spec.joint_models, positions, starts, measured, strict=True
        ):
            limits = joint.limits
            lower = min(limits.range_from(place)[0] for place in places)
            upper = max(limits.range_from(place)[1] for place in places)
            if not lower - CONTINUITY <= q <= upper + CONTINUITY:
                raise ControlError(
                    f"the position {q:.6g} rad of '{joint.name}' is beyond its limits "
                    f"[{limits.lower:.6g}, {limits.upper:.6g}]"
                )

    def require_velocities(self, velocities: Sequence[float]) -> None:
        """Raise ControlError if a velocity is beyond its joint's limit [rad/s]."""
        for joint, v in zip(self.spec.joint_models, velocities, strict=True):
            if not abs(v) <= joint.max_velocity + CONTINUITY:
                raise ControlError(
                    f"the velocity {v:.6g} rad/s of '{joint.name}' is beyond its "
                    f"limits ±{joint.max_velocity:.6g}"
                )

    def servo(self, now: float) -> ServoStream:
        """Return the stream that follows targets.

        The stream is started at ``now`` [s] if needed.
        """
        current = self._stream
        if isinstance(current, ServoStream):
            return current
        made = ServoStream(self.motion(now), self.spec.joint_models)
        self._start("servo", made, now)
        return made

    def speed(self, now: float) -> SpeedStream:
        """Return the stream of velocities.

        The stream is started at ``now`` [s] if needed.
        """
        current = self._stream
        if isinstance(current, SpeedStream):
            return current
        spec = self.spec
        made = SpeedStream(self.motion(now), spec.joint_models, spec.model)
        self._start("speed", made, now)
        return made

    def start_compliance(self, task: ComplianceTask, state: JointState) -> EffortLaw:
        """Start compliance for a task in ``state``, and return the joints' effort law.

        After the start, the controller's position commands are ignored.
        """
        self._state = state
        if task.is_freedrive:
            self._use(
                SplineMotion.holding(self._select(state.position), state.time),
                state.time,
            )
        compliance = Compliance(self.spec.model, task, self._select)
        self._compliance = compliance
        return compliance.efforts

    def start_torques(self, command: TorqueCommand, state: JointState) -> EffortLaw:
        """Start torque control in ``state``, and return the joints' effort law.

        After the start, the controller's position commands are ignored.

        Raises:
            ControlError: If a drive cannot provide the commanded torque.
        """
        torques = TorqueMode(self.spec.joint_models, self.spec.model, self._select)
        torques.aim(command)
        self._state = state
        positions = self._select(state.position)
        self._use(SplineMotion.holding(positions, state.time), state.time)
        self.torques = torques
        return torques.efforts

    def end_compliance(self, state: JointState, deceleration: float) -> None:
        """Ramp to rest from the measured motion, and resume position commands."""
        self._state = state
        start, now = self._measured(), state.time
        self._compliance = self.torques = None
        self._stop_from(start, now, deceleration)

    def _start(self, mode: Mode, stream: StreamedMotion, now: float) -> None:
        self._leave_path(now)
        self._stream, self._stream_mode = stream, mode

    def _use(self, splines: SplineMotion, now: float) -> None:
        self._leave_path(now)
        self._splines, self._stream = splines, None
        self._has_arrived, self._ended = False, None

    def _leave_path(self, now: float) -> None:
        self._last = self.progress(now)


def _tangents(setpoint: ArmSetpoint, time: float) -> tuple[JointSpline, ...]:
    """Return splines that match the motion of ``setpoint`` at ``time`` [s]."""
    return tuple(
        along(
            Segment.of(time, math.nextafter(time, math.inf), (q, v, 0.5 * a, 0, 0, 0))
        )
        for q, v, a in zip(*setpoint, strict=True)
    )
