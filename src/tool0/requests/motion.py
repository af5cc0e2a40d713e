"""Requests that move joints through their controllers, and the goals they start."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct, field

from tool0.control.goal import Goal, GoalStatus, ToleranceOverride
from tool0.control.trajectory import TrajectoryGoal, TrajectoryPoint
from tool0.errors import ControlError
from tool0.hardware.limits import DriveLimits
from tool0.requests.fields import JointPositions, Name, SpeedScale
from tool0.requests.table import Request, handles
from tool0.runtime.joint_motion import import_planner
from tool0.runtime.simulation import Simulation

Points = tuple[TrajectoryPoint, ...]
Tolerances = dict[str, ToleranceOverride]


class GoalStarted(Struct, frozen=True, kw_only=True):
    """A goal that a controller accepted."""

    goal: int
    """Its number."""
    controller: str


class FollowTrajectory(Request[GoalStarted], frozen=True):
    """Send a trajectory as a goal, as ROS's FollowJointTrajectory action does.

    No points stop the motion.
    """

    unchecked = ("points", "path_tolerance", "goal_tolerance")

    controller: Name
    points: Points
    """Positions, velocities and accelerations at ``time_from_start`` [s], in the order
    of ``joint_names``."""
    joint_names: tuple[str, ...] | None = None
    """The controller's, if left out."""
    stamp: float | None = None
    """Simulated time at which the trajectory starts [s]; now, if left out."""
    path_tolerance: Tolerances = field(default_factory=dict)
    """Joint → largest error on the way [rad | m]; below 0 disables the check."""
    goal_tolerance: Tolerances = field(default_factory=dict)
    """Joint → largest error at the end [rad | m]; below 0 disables the check."""
    goal_time_tolerance: float | None = None
    """Grace after the last point [s]; below 0 disables the check."""


class CommandTrajectory(Request[None], frozen=True):
    """Send a trajectory without a goal, as ROS's ``command`` topic does.

    No points stop the motion.
    """

    unchecked = ("points",)

    controller: Name
    points: Points = ()
    joint_names: tuple[str, ...] | None = None
    """The controller's, if left out."""
    stamp: float | None = None
    """Simulated time at which the trajectory starts [s]; now, if left out."""


class MoveJoints(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move joints smoothly by the running trajectory controllers that claim them.

    There is a goal for each controller concerned.  Their other joints continue to
    where they are going.
    """

    positions: JointPositions
    speed: SpeedScale = 0.5
    duration: Annotated[float, Meta(gt=0.0)] | None = None
    """Instead of a speed: how long the motion of one controller takes [s].  It is a
    cubic, and the controller's other joints keep their setpoints."""
    controller: Name | None = None
    """The controller whose joints they are; those that claim them, if left out."""


class SteerJoints(Request[None], frozen=True):
    """Move joints of a trajectory controller smoothly, without a goal.

    It is made for streams of setpoints: position, velocity and acceleration stay
    continuous however often it is sent.
    """

    controller: Name
    positions: JointPositions
    speed: SpeedScale = 0.5


class PoseJoints(Request[None], frozen=True):
    """Set joints directly; only in ``tool0 view``, which has no physics."""

    positions: JointPositions


class CommandGripper(Request[GoalStarted], frozen=True):
    """Send a gripper goal in joint units, as ROS's GripperCommand action does."""

    controller: Name
    position: float
    """[rad | m]"""
    max_effort: float | None = None
    """[N·m | N]; the controller's own, if left out."""


class CommandJoints(Request[None], frozen=True):
    """Send the setpoints of a forwarding controller."""

    controller: Name
    values: tuple[float, ...]
    """In the order of the controller's joints; the unit is its interface's."""


class CancelGoal(Request[None], frozen=True):
    """Stop a goal's motion as ROS does: ramp down; the goal is PREEMPTED."""

    goal: int


class ReadGoal(Request[GoalStatus], frozen=True):
    """The status of a goal."""

    goal: int


def started(simulation: Simulation, goal: Goal) -> GoalStarted:
    """Number an accepted goal."""
    return GoalStarted(goal=simulation.goals.add(goal), controller=goal.controller)


def follow(
    simulation: Simulation,
    controller: str,
    goal: TrajectoryGoal,
    bounds: dict[str, DriveLimits] | None = None,
) -> GoalStarted:
    """Start a trajectory goal between two ticks; from the thread that asks."""
    core = simulation.core
    accepted = simulation.loop.call(lambda: core.follow(controller, goal, bounds))
    return started(simulation, accepted)


@handles(FollowTrajectory)
def _follow(simulation: Simulation, request: FollowTrajectory) -> GoalStarted:
    goal = TrajectoryGoal(
        points=request.points,
        joint_names=request.joint_names,
        stamp=request.stamp,
        path_tolerance=request.path_tolerance,
        goal_tolerance=request.goal_tolerance,
        goal_time_tolerance=request.goal_time_tolerance,
    )
    return follow(simulation, request.controller, goal)


@handles(CommandTrajectory)
def _command(simulation: Simulation, request: CommandTrajectory) -> None:
    goal = TrajectoryGoal(
        points=request.points, joint_names=request.joint_names, stamp=request.stamp
    )
    core = simulation.core
    simulation.loop.call(lambda: core.command_trajectory(request.controller, goal))


@handles(MoveJoints)
def _move(simulation: Simulation, request: MoveJoints) -> tuple[GoalStarted, ...]:
    import_planner()  # slow the first time: not in the thread of the tick
    core, duration = simulation.core, request.duration
    if duration is not None:
        goal = simulation.loop.call(
            lambda: core.move_joints_within(
                request.positions, duration, request.controller
            )
        )
        return (started(simulation, goal),)
    goals = simulation.loop.call(
        lambda: core.move_joints(request.positions, request.speed, request.controller)
    )
    return tuple(started(simulation, goal) for goal in goals)


@handles(SteerJoints)
def _steer(simulation: Simulation, request: SteerJoints) -> None:
    import_planner()
    core = simulation.core
    simulation.loop.call(
        lambda: core.steer(request.controller, request.positions, request.speed)
    )


@handles(PoseJoints)
def _pose(simulation: Simulation, request: PoseJoints) -> None:
    raise ControlError(
        "joints are set directly in `tool0 view` only; in a simulation, steer a "
        "trajectory controller"
    )


@handles(CommandGripper, in_tick=True)
def _command_gripper(simulation: Simulation, request: CommandGripper) -> GoalStarted:
    goal = simulation.core.command_gripper(
        request.controller, request.position, request.max_effort
    )
    return started(simulation, goal)


@handles(CommandJoints, in_tick=True)
def _command_joints(simulation: Simulation, request: CommandJoints) -> None:
    simulation.core.command_joints(request.controller, request.values)


@handles(CancelGoal, in_tick=True)
def _cancel(simulation: Simulation, request: CancelGoal) -> None:
    simulation.core.cancel(simulation.goals.find(request.goal))


@handles(ReadGoal)
def _read_goal(simulation: Simulation, request: ReadGoal) -> GoalStatus:
    return simulation.goals.find(request.goal).status
