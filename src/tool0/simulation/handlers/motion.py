"""Handlers of the requests to controllers and to the controller manager."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tool0.control.config import ControllerConfig
from tool0.control.controller import ControllerSpec
from tool0.control.manager import Strictness
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.drive_limits import DriveLimits
from tool0.description.parts import joints_of_robot
from tool0.protocol.controllers import (
    CleanupController,
    ConfigureController,
    ControllerParameter,
    ControllerTypeInfo,
    Gains,
    ListControllers,
    ListControllerTypes,
    LoadController,
    QueryState,
    ReadController,
    ReadControllerParameters,
    ReadGains,
    SetControllerParameters,
    SetGains,
    SwitchControllers,
    UnloadController,
)
from tool0.protocol.goals import (
    CancelGoal,
    Goal,
    GoalStarted,
    ReadGoal,
)
from tool0.protocol.motion import (
    CommandGripper,
    CommandJoints,
    GripLimits,
    MoveJoints,
    SteerJoints,
)
from tool0.protocol.poses import DeletePose, GoToPose, ListPoses, SavePose
from tool0.protocol.request import Name, Request
from tool0.protocol.trajectories import (
    CommandTrajectory,
    FollowTrajectory,
    JointsMotion,
    ScaleTrajectory,
)
from tool0.simulation.handlers.motion_checks import require_free
from tool0.simulation.handlers.table import answer, handles
from tool0.simulation.simulation import Simulation


def started(simulation: Simulation, goal: Goal) -> GoalStarted:
    """Assign a number to an accepted goal."""
    return GoalStarted(goal=simulation.goals.add(goal), controller=goal.controller)


def drive_limits(simulation: Simulation, limits: GripLimits) -> DriveLimits:
    """Return the limits of a gripper drive, or raise ControlError."""
    return DriveLimits(
        gripper=simulation.gripper(limits.gripper),
        speed=limits.speed,
        force=limits.force,
        effort=limits.effort,
    )


def _trajectory(simulation: Simulation, request: FollowTrajectory) -> TrajectoryGoal:
    return TrajectoryGoal(
        points=request.points,
        joint_names=request.joint_names,
        stamp=request.stamp,
        path_tolerance=request.path_tolerance,
        goal_tolerance=request.goal_tolerance,
        goal_time_tolerance=request.goal_time_tolerance,
    )


@handles(FollowTrajectory, in_tick=True, prepare=_trajectory)
def _follow(
    simulation: Simulation, request: FollowTrajectory, goal: TrajectoryGoal
) -> GoalStarted:
    bounds = None
    if request.grip is not None:
        limits = drive_limits(simulation, request.grip)
        bounds = {limits.gripper.joint: limits}
    return started(
        simulation, simulation.executor.follow(request.controller, goal, bounds)
    )


def _command_goal(simulation: Simulation, request: CommandTrajectory) -> TrajectoryGoal:
    return TrajectoryGoal(
        points=request.points, joint_names=request.joint_names, stamp=request.stamp
    )


@handles(CommandTrajectory, in_tick=True, prepare=_command_goal)
def _command(
    simulation: Simulation, request: CommandTrajectory, goal: TrajectoryGoal
) -> None:
    simulation.executor.command_trajectory(request.controller, goal)


@handles(ScaleTrajectory, in_tick=True)
def _scale(simulation: Simulation, request: ScaleTrajectory) -> None:
    simulation.executor.scale_trajectory(request.controller, request.factor)


def _import_planner(simulation: Simulation, request: Request[Any]) -> None:
    """Import the planner outside the thread of the tick.

    The first import is slow.
    """
    from tool0.motion.joint import import_planner

    import_planner()


def _prepare_move(simulation: Simulation, request: MoveJoints) -> None:
    """Execute the slow part of ``MoveJoints``.

    CollisionError is raised if the motion would cause a collision and the request does
    not ignore collisions.
    """
    _import_planner(simulation, request)
    if request.collision == "refuse":
        require_free(simulation, request.positions)


@handles(MoveJoints, in_tick=True, prepare=_prepare_move)
def _move(
    simulation: Simulation, request: MoveJoints, prepared: None
) -> tuple[GoalStarted, ...]:
    executor, positions = simulation.executor, request.positions
    controller = request.controller
    if request.duration is None:
        goals = executor.move_joints(positions, request.speed, controller)
    else:
        goals = executor.move_joints_within(positions, request.duration, controller)
    return tuple(started(simulation, goal) for goal in goals)


@handles(SteerJoints, in_tick=True, prepare=_import_planner)
def _steer(simulation: Simulation, request: SteerJoints, prepared: None) -> None:
    simulation.executor.steer(request.controller, request.positions, request.speed)


@handles(CommandGripper, in_tick=True)
def _command_gripper(simulation: Simulation, request: CommandGripper) -> GoalStarted:
    grip = request.grip
    goal = simulation.executor.command_gripper(
        request.controller,
        request.position,
        request.max_effort,
        None if grip is None else drive_limits(simulation, grip),
        max_velocity=request.max_velocity,
    )
    return started(simulation, goal)


handles(CommandJoints, in_tick=True)(
    lambda sim, request: sim.executor.command_joints(request.controller, request.values)
)


@handles(CancelGoal, in_tick=True)
def _cancel(simulation: Simulation, request: CancelGoal) -> None:
    goal = simulation.goals.find(request.goal)
    if not simulation.program_runs.cancel(goal):
        simulation.executor.cancel(goal)


handles(ReadGoal)(lambda sim, request: sim.goals.find(request.goal).status)


# ---- named poses ------------------------------------------------------------------


handles(ListPoses)(lambda sim, _: dict(sim.poses.all()))


@handles(SavePose)
def _save_pose(simulation: Simulation, request: SavePose) -> None:
    model, position = simulation.description.model, simulation.snapshot.positions
    joints = model.joint_by_name
    driven = {
        item.joint: joints[item.joint].limits.clamp(position[item.joint])
        for item in model.transmissions
    }
    robot = request.robot
    positions = joints_of_robot(model, driven, robot)
    simulation.poses.save(request.name, positions, update=robot is not None)


handles(DeletePose)(lambda sim, request: sim.poses.delete(request.name))


@handles(GoToPose)
def _go(simulation: Simulation, request: GoToPose) -> tuple[GoalStarted, ...]:
    positions = simulation.poses.goal(request.name, request.robot)
    return answer(
        simulation,
        MoveJoints(
            positions=positions, speed=request.speed, collision=request.collision
        ),
    )


# ---- controllers --------------------------------------------------------------------


class LoadControllerWith(Request[None], frozen=True):
    """Load a controller with the given parameters."""

    unchecked = ("config",)

    name: Name
    config: ControllerConfig | None = None
    """Configuration of the controllers; None for the configuration of the bring-up."""
    configure: bool = True


class ReadControllerSpec(Request[ControllerSpec], frozen=True):
    """Parameters with which a controller was loaded."""

    controller: Name


handles(ListControllers)(lambda sim, _: sim.snapshot.controllers)
handles(ConfigureController, in_tick=True)(
    lambda sim, request: sim.core.manager.configure(request.name)
)
handles(CleanupController, in_tick=True)(
    lambda sim, request: sim.core.manager.cleanup(request.name)
)
handles(LoadControllerWith, in_tick=True, local=True)(
    lambda sim, request: sim.core.manager.load(
        request.name, request.config, configure=request.configure
    )
)
handles(UnloadController, in_tick=True)(
    lambda sim, request: sim.core.manager.unload(request.name)
)


@handles(LoadController)
def _load(simulation: Simulation, request: LoadController) -> None:
    name, manager = request.name, simulation.core.manager
    config = None
    if request.files:
        arguments = simulation.description.arguments
        config = ControllerConfig.from_files(map(Path, request.files), arguments)
    if request.type is not None:
        config = (config or manager.config).with_type(name, request.type)
    configure = request.configure or manager.dialect.is_configured_when_loaded
    loaded = LoadControllerWith(name=name, config=config, configure=configure)
    answer(simulation, loaded)


@handles(ListControllerTypes)
def _types(
    simulation: Simulation, request: ListControllerTypes
) -> tuple[ControllerTypeInfo, ...]:
    dialect = simulation.core.manager.dialect
    return tuple(
        ControllerTypeInfo(name=name, base=dialect.bases[kind.role])
        for name, kind in sorted(dialect.types.items())
    )


@handles(SwitchControllers, in_tick=True)
def _switch(simulation: Simulation, request: SwitchControllers) -> None:
    core = simulation.core
    strictness = Strictness.STRICT if request.strict else Strictness.BEST_EFFORT
    core.manager.switch(request.start, request.stop, strictness, core.state)


handles(ReadController, in_tick=True, publishes=False)(
    lambda sim, request: (
        sim.executor.trajectory_controller(request.controller).setpoint().state()
    )
)


@handles(QueryState, in_tick=True, publishes=False)
def _query(simulation: Simulation, request: QueryState) -> JointsMotion:
    controller = simulation.executor.trajectory_controller(request.controller)
    time = simulation.core.time if request.time is None else request.time
    return controller.query_state(time)


@handles(ReadGains, in_tick=True, publishes=False)
def _gains(simulation: Simulation, request: ReadGains) -> dict[str, Gains]:
    spec = simulation.core.manager.spec(request.controller)
    return dict(zip(spec.joints, spec.gains, strict=False))


@handles(SetGains, in_tick=True, changes=True, publishes=False)
def _set_gains(simulation: Simulation, request: SetGains) -> Gains:
    given = {name: getattr(request, name) for name in ("p", "i", "d", "antiwindup")}
    if (clamp := request.i_clamp) is not None:
        given |= {"i_min": -clamp, "i_max": clamp}
    changes = {name: value for name, value in given.items() if value is not None}
    manager = simulation.core.manager
    return manager.set_gains(request.controller, request.joint, **changes)


@handles(ReadControllerParameters, in_tick=True, publishes=False)
def _parameters(
    simulation: Simulation, request: ReadControllerParameters
) -> dict[str, ControllerParameter]:
    values, adjustable = simulation.core.manager.parameters(request.controller)
    return {
        name: ControllerParameter(value=value, is_adjustable=name in adjustable)
        for name, value in values.items()
    }


handles(SetControllerParameters, in_tick=True)(
    lambda sim, request: sim.core.manager.set_parameters(
        request.controller, request.parameters
    )
)
handles(ReadControllerSpec, in_tick=True, publishes=False, local=True)(
    lambda sim, request: sim.core.manager.spec(request.controller)
)
