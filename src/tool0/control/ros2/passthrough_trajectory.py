"""PassthroughTrajectoryController from Universal Robots: the arm follows the points.

Like JointTrajectoryController, PassthroughTrajectoryController commands positions and
follows splines.  The splines are quintic between points with accelerations, and cubic
between points with velocities.  If the points have only positions, the arm comes to
rest at each point.  The controller accepts one goal at a time, and checks the position
of the arm only at the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

from tool0.control.parameters import RobotJoints, controlled_joints
from tool0.control.ros2.joint_trajectory import (
    JointTrajectoryController,
    JointTrajectorySpec,
)
from tool0.control.ros2.trajectory_check import Acceptance
from tool0.control.ros2.trajectory_parameters import (
    SPEED_SCALING,
    read_states,
    speed_prefix,
)
from tool0.control.ros2.trajectory_settings import Replacement, SpeedSource
from tool0.control.spline import MotionPlan
from tool0.control.tolerances import (
    JointTolerances,
    TrajectoryTolerances,
    as_tolerance,
)
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Interface
from tool0.description.yaml_values import Namespace
from tool0.errors import GoalRejectedError
from tool0.hardware.engine import JointState
from tool0.protocol.goals import Goal, GoalResult, GoalStatus

STOP_DECELERATION: Final = 4.0
"""Deceleration of each joint after a cancellation [rad/s²]."""
MOST_JUMP: Final = 0.05
"""Largest deviation of a joint from the first point of a goal if the time of this point
is 0 [rad]."""
_NUMBERS: Final = ("positions", "velocities", "accelerations")
_DEACTIVATED: Final = GoalResult(
    status=GoalStatus.ABORTED,
    error_code=GoalResult.INVALID_GOAL,
    error_string="Aborting current goal, since the controller is being deactivated.",
)


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> PassthroughTrajectorySpec:
    """Return the checked parameters of a PassthroughTrajectoryController."""
    prefix = parameters.text("tf_prefix", "")
    joints = controlled_joints(robot, parameters, Interface.POSITION)
    states = read_states(parameters, robot, joints, Interface.POSITION)
    path = "speed_scaling_interface_name"
    scaling = parameters.text(path, SPEED_SCALING)
    n = len(joints)
    setpoints = (f"setpoint_{kind}_{k}" for k in range(n) for kind in _NUMBERS)
    others = ("abort", "transfer_state", "time_from_start", "trajectory_size")
    return PassthroughTrajectorySpec(
        name=name,
        type=type_name,
        joint_models=joints,
        interface=Interface.POSITION,
        further_interfaces=tuple(
            f"{prefix}trajectory_passthrough/{item}" for item in (*setpoints, *others)
        ),
        state_interfaces=(
            *(f"{joint.name}/{kind}" for joint in joints for kind in states),
            scaling,
        ),
        reads_velocity="velocity" in states,
        acceptance=Acceptance(tuple(joint.name for joint in joints)),
        tolerances=TrajectoryTolerances(goal_time=0.0),
        deceleration=(STOP_DECELERATION,) * n,
        replacement=Replacement(is_spliced=False, from_desired=True),
        speed=SpeedSource(
            is_settable=False,
            factors=robot.speed_scaling,
            prefix=speed_prefix(parameters, path, scaling, robot),
        ),
    )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PassthroughTrajectorySpec(JointTrajectorySpec):
    """The parameters of a PassthroughTrajectoryController."""

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> PassthroughTrajectoryController:
        return PassthroughTrajectoryController(self, indices, state)


@final
class PassthroughTrajectoryController(JointTrajectoryController):
    """Follows one trajectory at a time.

    The goal of the trajectory sets the tolerances at the end.
    """

    _duration = 0.0
    """Duration of the goal's trajectory [s]."""

    def follow(self, goal: TrajectoryGoal | MotionPlan, now: float) -> Goal:
        """Execute ``goal`` and return its handle, or reject the goal.

        Raises:
            GoalRejectedError: If the goal is invalid, or another goal is being
                executed.
        """
        if isinstance(goal, TrajectoryGoal):
            if self._monitor is not None and self._monitor.goal is not None:
                raise GoalRejectedError(
                    "Can't accept new trajectory. A trajectory is already executing."
                )
            goal = self._checked(goal, now)
        handle = super().follow(goal, now)
        if isinstance(goal, TrajectoryGoal):
            self._duration = goal.times[-1]
        return handle

    def stop_where_it_is(self, state: JointState, reason: str) -> None:
        """Decelerate the joints from their measured motion, and abort the goal."""
        self.observe(state)
        self._finish(
            GoalResult(
                status=GoalStatus.ABORTED,
                error_code=GoalResult.INVALID_GOAL,
                error_string=reason,
            )
        )
        self._monitor = None
        self._come_to_rest(self._clock.at(state.time))

    def stop(self) -> None:
        self._finish(_DEACTIVATED)
        super().stop()

    def _checked(self, goal: TrajectoryGoal, now: float) -> TrajectoryGoal:
        """Return a goal in the form that the arm executes, or reject the goal."""
        joints = self.spec.joints
        if goal.points:
            _check_sizes(goal, len(joints))
        _check_tolerances(goal, joints)
        if goal.points and goal.times[0] == 0.0:
            self._check_first(goal, now)
        points = goal.points
        if points and not points[0].velocities:
            rest = (0.0,) * len(joints)
            points = [replace(p, velocities=rest, accelerations=None) for p in points]
        return replace(goal, points=points, stamp=None)

    def _check_first(self, goal: TrajectoryGoal, now: float) -> None:
        """Reject a goal that does not start at the arm's position.

        The arm cannot jump to the start.
        """
        names = goal.joint_names or self.spec.joints
        place = dict(
            zip(self.spec.joints, self.query_state(now).positions, strict=True)
        )
        for name, position in zip(names, goal.points[0].positions, strict=False):
            if name in place and abs(position - place[name]) > MOST_JUMP:
                raise GoalRejectedError(
                    f"Point nr 1 is at time 0 and {position - place[name]:.6g} rad "
                    f"from where '{name}' is; give it a later time_from_start"
                )

    def _tolerances_of(self, goal: TrajectoryGoal) -> TrajectoryTolerances:
        """Return the tolerances of the goal for the end of the trajectory.

        The controller has no default tolerances.
        """
        return TrajectoryTolerances(
            joints={
                name: JointTolerances(goal=as_tolerance(given))
                for name, given in goal.goal_tolerance.items()
            },
            goal_time=max(goal.goal_time_tolerance or 0.0, 0.0),
        )

    def _end(
        self, result: GoalResult, time: float, errors: Sequence[float] = ()
    ) -> None:
        super()._end(self._worded(result), time, errors)

    def _worded(self, result: GoalResult) -> GoalResult:
        """Return a result with the wording of PassthroughTrajectoryController."""
        text = result.error_string
        if result.status is GoalStatus.SUCCEEDED:
            text = (
                f"Trajectory executed successfully in {self._duration:f} (scaled) "
                "seconds! The real time needed for execution could be longer."
            )
        elif result.is_violation:
            text = "Robot not within tolerances at end of trajectory."
        return replace(result, error_string=text)


def _check_sizes(goal: TrajectoryGoal, n_joints: int) -> None:
    """Reject points that lack values or do not match the first point.

    All points must have the same kinds of values as the first point.
    """
    first = goal.points[0]
    for number, point in enumerate(goal.points, 1):
        for kind in _NUMBERS:
            n, n_first = (len(getattr(each, kind) or ()) for each in (point, first))
            if n != n_first or n not in {n_joints, 0 if kind != "positions" else -1}:
                raise GoalRejectedError(
                    f"Can't accept new trajectory. All trajectory points must have "
                    f"{kind} for all joints of the robot"
                    + ("" if kind == "positions" else ", or none of them may")
                    + f". ({n_joints} joint {kind} per point) "
                    f"Point nr {number} has: {n} {kind}."
                )


def _check_tolerances(goal: TrajectoryGoal, joints: Sequence[str]) -> None:
    for name in goal.goal_tolerance:
        if name not in joints:
            raise GoalRejectedError(
                f"Tolerance for joint '{name}' given. This joint is not known to this "
                "controller."
            )
    n = len(goal.goal_tolerance)
    if n not in {0, len(joints)}:
        raise GoalRejectedError(
            f"Tolerances for {n} joints given. This controller knows {len(joints)} "
            "joints."
        )
