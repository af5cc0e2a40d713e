"""GripperActionController: moves one joint, and squeezes the object that stops it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from tool0.control.law import GripperLaw, GripState
from tool0.control.parameters import Pid, read_gains
from tool0.control.position_limits import check_position
from tool0.control.spline import hold
from tool0.control.trajectory import Setpoint
from tool0.description.drive_limits import DriveLimits
from tool0.description.model import Interface, Joint, ParallelGripper
from tool0.description.yaml_values import Namespace
from tool0.errors import GoalRejectedError
from tool0.hardware.engine import JointState, joint_selector
from tool0.protocol.controllers import Gains
from tool0.protocol.goals import Goal, GoalStatus, GripperResult

_IN_PADS = "set_gripper_max_"
"""Part of the name of interfaces that set the speed [m/s] or the force [N] at the pads.
Other interfaces set the speed and the effort of the joint."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DriveSettings:
    """Drive speed and effort that goals set; parameters define the defaults.

    The values are written to the interfaces and refer to the pads or to the joint.
    """

    gripper: ParallelGripper | None
    """The gripper; None if the description does not specify how the opening depends on
    the joint.  Without a gripper, the drive has no speed or effort settings."""
    effort_interface: str
    """Interface for the effort; empty if the effort is not set.  ``velocity_interface``
    is the corresponding interface for the speed."""
    velocity_interface: str
    max_effort: float
    """Effort for goals that do not specify an effort [N | N·m]."""
    max_velocity: float
    """Speed for goals that do not specify a speed [m/s | rad/s]."""

    @property
    def interfaces(self) -> tuple[str, ...]:
        """The command interfaces that are claimed."""
        return tuple(filter(None, (self.effort_interface, self.velocity_interface)))

    def limits(
        self, effort: float | None, velocity: float | None
    ) -> DriveLimits | None:
        """Return the limits for the drive; None if the drive's own limits apply.

        Settings beyond the range are clamped, as they are in the gripper's driver.
        """
        gripper = self.gripper
        if gripper is None or not self.interfaces:
            return None
        speed = force = torque = None
        if self.velocity_interface:
            speed = abs(self.max_velocity if velocity is None else velocity)
            if _IN_PADS not in self.velocity_interface:
                speed *= gripper.lever(gripper.position(gripper.max_opening / 2.0))
            speed = _within(speed, gripper.speed)
        if self.effort_interface:
            given = abs(self.max_effort if effort is None else effort)
            if _IN_PADS in self.effort_interface or given == 0.0:
                force = _within(given, gripper.force)
            else:
                torque = given
        return DriveLimits(gripper=gripper, speed=speed, force=force, effort=torque)


def _within(value: float, span: tuple[float, float]) -> float:
    return min(max(value, span[0]), span[1])


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GripperActionSpec:
    """The parameters of a gripper controller, in units of the gripper's joint.

    The units are [rad] and [N·m], or [m] and [N].
    """

    name: str
    type: str
    joint: Joint
    interface: Interface
    gains: tuple[Gains, ...]
    """Gains of the joint; empty for the position interface."""
    goal_tolerance: float = 0.01
    max_effort: float
    """Effort limit at the start, after a cancellation, and for goals without an effort
    limit [N·m | N]."""
    stall_velocity_threshold: float = 0.001
    """Mean speed below which the joint is considered stalled [rad/s | m/s]."""
    stall_timeout: float = 1.0
    """Time for which the joint must be slower than ``stall_velocity_threshold`` [s]."""
    allow_stalling: bool = False
    """Whether a stall is treated as success, since the gripper holds an object."""
    action_monitor_rate: float = 20.0
    """Rate of the feedback of the ROS action [Hz]."""
    state_interfaces: tuple[str, ...] = ()
    settings: DriveSettings | None = None
    """Drive settings that goals can set; None if goals cannot set any."""

    waits_for_command: ClassVar[bool] = False

    @property
    def joints(self) -> tuple[str, ...]:
        return (self.joint.name,)

    @property
    def further_interfaces(self) -> tuple[str, ...]:
        """The command interfaces for the drive's settings."""
        return () if self.settings is None else self.settings.interfaces

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> GripperActionController:
        return GripperActionController(self, indices[0], state)


@final
class GripperActionController:
    """Moves one joint to a position with limited effort.

    A goal succeeds when the error is below ``goal_tolerance``.  If the joint stalls
    with a larger error, the goal is aborted, or it succeeds if ``allow_stalling`` is
    set.  After a success or an abort, the command remains in effect: a gripper
    continues to squeeze with the goal's effort.  The controller behaves like the ROS
    controllers of the same name, with these improvements:

    * a stall is a *change of position* of less than ``stall_velocity_threshold *
      stall_timeout`` during ``stall_timeout``: in ROS, the velocity of a simulated grip
      chatters above any threshold, so goals that hold an object never end;
    * a goal with a ``max_effort`` of 0 uses the effort limit of the controller instead
      of no effort; without the parameter ``max_effort``, this limit is the joint's
      effort limit;
    * positions beyond the joint's limits and numbers that are not finite are rejected.
    """

    def __init__(self, spec: GripperActionSpec, index: int, state: JointState) -> None:
        self.spec = spec
        self._index = index
        self._select = joint_selector((index,))
        self._state = state
        self.pid = Pid(spec.gains) if spec.gains else None
        self._target = state.position[index]
        self._position = self._target
        self._hold = hold(state.time, self._target)
        self._drive_limits: DriveLimits | None = None
        self._max_effort = spec.max_effort
        self._grip = GripState(self._target, self._target, state.time)
        self._goal: Goal | None = None
        self._stall_range = spec.stall_velocity_threshold * spec.stall_timeout

    @property
    def joint(self) -> Joint:
        return self.spec.joint

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the joint's command: the target position, or an effort toward it."""
        self._state = state
        position = self._position = state.position[self._index]
        if self._goal is not None:
            self._check_goal(state.time, position, self._target - position)
        if self.pid is None:
            self._grip.effort = self._max_effort
            return (self._target,)
        error = self._advance_ramp(period) - position
        (effort,) = self.pid.update([error], [-state.velocity[self._index]], period)
        bound = self._max_effort
        self._grip.effort = -bound if effort < -bound else min(effort, bound)
        return (self._grip.effort,)

    def law(self) -> GripperLaw:
        spec = self.spec
        return GripperLaw(
            self._target,
            spec.goal_tolerance,
            self._max_effort,
            self._stall_range,
            spec.stall_timeout,
            self._goal is not None,
            self.pid,
            self._drive_limits,
            self._grip,
            self._position,
            spec.max_effort,
        )

    def observe(self, state: JointState) -> None:
        self._state = state
        self._position = state.position[self._index]

    def _advance_ramp(self, period: float) -> float:
        """Return the current setpoint, which approaches the target at a limited speed.

        If the PID received the full error, its integral term would wind up while the
        drive is slow.
        """
        if self._drive_limits is None:
            self._grip.ramp = self._target
        else:
            _, speed = self._drive_limits.at(self._grip.ramp)
            left = self._target - self._grip.ramp
            self._grip.ramp += min(max(left, -speed * period), speed * period)
        return self._grip.ramp

    def _check_goal(self, time: float, position: float, error: float) -> None:
        if abs(error) < self.spec.goal_tolerance:
            self._finish(GoalStatus.SUCCEEDED, reached_goal=True)
        elif abs(position - self._grip.stall_position) > self._stall_range:
            self._grip.stall_position, self._grip.stall_since = position, time
        elif time - self._grip.stall_since > self.spec.stall_timeout:
            is_success = self.spec.allow_stalling
            self._finish(
                GoalStatus.SUCCEEDED if is_success else GoalStatus.ABORTED, stalled=True
            )

    def drive(
        self,
        position: float,
        max_effort: float | None,
        now: float,
        drive_limits: DriveLimits | None = None,
    ) -> Goal:
        """Start a new goal and return its handle, or reject the goal.

        The sign of ``max_effort`` [N·m | N] is ignored, as it is in ROS.  If
        ``max_effort`` is None or 0, the value of the controller applies.
        ``drive_limits`` apply during the goal.

        Raises:
            GoalRejectedError: If the goal is rejected; the previous command stays in
                effect.
        """
        if not math.isfinite(position):
            raise GoalRejectedError(f"position {position}; it must be finite")
        if max_effort is not None and not math.isfinite(max_effort):
            raise GoalRejectedError(f"max_effort {max_effort}; it must be finite")
        check_position(self.spec.joint, position, f"a goal of '{self.spec.name}'")
        self._finish(GoalStatus.PREEMPTED)
        self._goal = goal = Goal(self.spec.name)
        self._move_to(float(position), drive_limits, now)
        lead = self._grip.ramp - self._position
        distance = self._target - self._position
        # Another squeeze in the same direction must not release the object.
        if lead * distance <= 0.0:
            self._grip.ramp = self._position
        elif abs(lead) > abs(distance):
            self._grip.ramp = self._target
        self._max_effort = abs(max_effort or 0.0) or self.spec.max_effort
        self._grip.stall_position, self._grip.stall_since = self._position, now
        return goal

    def resume_from_kernel(
        self,
        target: float,
        max_effort: float,
        drive_limits: DriveLimits | None,
        now: float,
        *,
        has_goal: bool,
    ) -> None:
        """Continue with a goal that the kernel started at ``now`` [s].

        The kernel may also have completed the goal.  Clients have no handle for a goal
        that the kernel started.
        """
        self._finish(GoalStatus.PREEMPTED)
        self._goal = Goal(self.spec.name) if has_goal else None
        self._move_to(target, drive_limits, now)
        self._max_effort = max_effort

    def _move_to(
        self, target: float, drive_limits: DriveLimits | None, now: float
    ) -> None:
        self._target, self._drive_limits = target, drive_limits
        self._hold = hold(now, target)

    def limits(
        self, max_effort: float | None, max_velocity: float | None
    ) -> DriveLimits | None:
        """Return the limits of the drive for the settings of a goal."""
        settings = self.spec.settings
        return None if settings is None else settings.limits(max_effort, max_velocity)

    def adjust(self, spec: GripperActionSpec) -> None:
        """Continue with changed tolerances and settings."""
        self.spec = spec
        self._stall_range = spec.stall_velocity_threshold * spec.stall_timeout

    def cancel(self, goal: Goal, now: float) -> None:
        """Hold the measured position if ``goal`` is the active goal."""
        if goal is self._goal and goal is not None:
            self._target = self._grip.ramp = self._position
            self._hold = hold(now, self._target)
            self._max_effort = self.spec.max_effort
            self._finish(GoalStatus.PREEMPTED)

    def setpoint(self) -> Setpoint:
        return Setpoint((self.spec.joint,), (self._hold,), self._select, self._state)

    def stop(self) -> None:
        self._finish(GoalStatus.PREEMPTED)

    def _finish(
        self, status: GoalStatus, *, stalled: bool = False, reached_goal: bool = False
    ) -> None:
        goal, self._goal = self._goal, None
        if goal is not None:
            is_measured = self.spec.settings is not None
            efforts = self._state.effort
            goal.finish(
                GripperResult(
                    status=status,
                    position=self._position,
                    effort=efforts[self._index] if is_measured else self._grip.effort,
                    stalled=stalled,
                    reached_goal=reached_goal,
                )
            )


def read_gripper_action(
    name: str,
    type_name: str,
    parameters: Namespace,
    joint: Joint,
    interface: Interface,
    *,
    goal_tolerance: float,
    max_effort: float,
    action_monitor_rate: float,
    state_interfaces: tuple[str, ...] = (),
    settings: DriveSettings | None = None,
    delay: float = 0.0,
) -> GripperActionSpec:
    """Return the parameters of a gripper controller.

    Gains and stall settings are read from ``parameters``; other values are passed as
    arguments.

    ``delay`` [s] is added to the stall timeout, since the state is delayed by
    ``delay``.
    """
    gains: tuple[Gains, ...] = ()
    if interface is Interface.EFFORT:
        path = f"gains/{joint.name}"
        gains = (read_gains(parameters, path, f"{type_name} needs"),)
    return GripperActionSpec(
        name=name,
        type=type_name,
        joint=joint,
        interface=interface,
        gains=gains,
        goal_tolerance=goal_tolerance,
        max_effort=max_effort,
        stall_velocity_threshold=parameters.not_negative(
            "stall_velocity_threshold", 0.001
        ),
        stall_timeout=parameters.not_negative("stall_timeout", 1.0) + delay,
        allow_stalling=parameters.boolean("allow_stalling", default=False),
        action_monitor_rate=action_monitor_rate,
        state_interfaces=state_interfaces,
        settings=settings,
    )
