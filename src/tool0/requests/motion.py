"""Requests to controllers and their manager, and the goals that they start."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Generic

from msgspec import Meta, Struct, field

from tool0.control.config import ControllerConfig
from tool0.control.controller import ControllerSpec
from tool0.control.goal import Goal, GoalStatus, ToleranceOverride
from tool0.control.manager import Strictness
from tool0.control.parameters import Gains
from tool0.control.status import ControllerStatus
from tool0.control.trajectory import (
    JointsMotion,
    TrajectoryGoal,
    TrajectoryPoint,
    TrajectoryState,
)
from tool0.description.parts import joints_of_robot
from tool0.errors import ControlError
from tool0.hardware.limits import DriveLimits
from tool0.requests.table import (
    JointPositions,
    Name,
    Request,
    Response,
    SpeedScale,
    answer,
    handles,
)
from tool0.runtime.joint_motion import import_planner
from tool0.runtime.poses import NamedPose
from tool0.runtime.simulation import Simulation

Points = tuple[TrajectoryPoint, ...]
Tolerances = dict[str, ToleranceOverride]


class GoalStarted(Struct, frozen=True, kw_only=True):
    """A goal that a controller accepted."""

    goal: int
    """Its number."""
    controller: str


class _OfTrajectory(Request[Response], Generic[Response], frozen=True):
    """The fields of every request with a trajectory."""

    unchecked = ("points", "path_tolerance", "goal_tolerance")

    controller: Name
    points: Points
    """Positions, velocities and accelerations at ``time_from_start`` [s], in the order
    of ``joint_names``."""
    joint_names: tuple[str, ...] | None = None
    """The controller's, if left out."""
    stamp: float | None = None
    """Simulated time at which the trajectory starts [s]; now, if left out."""


class GripLimits(Struct, frozen=True, kw_only=True):
    """Limits of a gripper's drive, until its next goal."""

    gripper: Name | None = None
    """The robot's only one, if left out."""
    speed: float | None = None
    """Of the pads relative to each other [m/s]."""
    force: float | None = None
    """At each pad [N]."""
    effort: float | None = None
    """Instead of a force: of the driven joint [N·m | N]."""


class FollowTrajectory(_OfTrajectory[GoalStarted], frozen=True):
    """Send a trajectory as a goal, as ROS's action does; no points stop the motion."""

    path_tolerance: Tolerances = field(default_factory=dict)
    """Joint → largest error on the way [rad | m]; below 0 disables the check."""
    goal_tolerance: Tolerances = field(default_factory=dict)
    """Joint → largest error at the end [rad | m]; below 0 disables the check."""
    goal_time_tolerance: float | None = None
    """Grace after the last point [s]; below 0 disables the check."""
    grip: GripLimits | None = None
    """Limits of a gripper whose joint moves; the joint's own, if left out."""


class CommandTrajectory(_OfTrajectory[None], frozen=True):
    """Send a trajectory without a goal; no points stop the motion."""

    points: Points = ()


class ScaleTrajectory(Request[None], frozen=True):
    """Scale the speed of a controller's trajectories, as ROS 2's speed_scaling_input.

    Its tolerances are judged by the slower trajectory.
    """

    controller: Name
    factor: Annotated[float, Meta(ge=0.0)]
    """Trajectory time per simulated time; 0 pauses."""


class MoveJoints(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move joints smoothly; there is a goal for each trajectory controller."""

    positions: JointPositions
    speed: SpeedScale = 0.5
    duration: Annotated[float, Meta(gt=0.0)] | None = None
    """Instead of a speed: duration of the motion of one controller [s].  It is a
    cubic, and the controller's other joints keep their setpoints."""
    controller: Name | None = None
    """The controller whose joints they are; those that claim them, if left out."""


class SteerJoints(Request[None], frozen=True):
    """Move joints of a trajectory controller smoothly, as streams of setpoints do."""

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
    """[N·m | N]; the controller's own, if left out.  ROS 2's parallel gripper writes it
    to its ``max_effort_interface``: at the pads [N], if that is the gripper's."""
    max_velocity: float | None = None
    """Of ROS 2's parallel gripper, for its ``max_velocity_interface`` [rad/s | m/s], or
    between the pads [m/s]; the controller's own, if left out."""
    grip: GripLimits | None = None
    """Limits between the pads, instead of the two above."""


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


def drive_limits(simulation: Simulation, limits: GripLimits) -> DriveLimits:
    """Return the limits of a gripper's drive, or raise ControlError."""
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
    return started(simulation, simulation.core.follow(request.controller, goal, bounds))


def _command_goal(simulation: Simulation, request: CommandTrajectory) -> TrajectoryGoal:
    return TrajectoryGoal(
        points=request.points, joint_names=request.joint_names, stamp=request.stamp
    )


@handles(CommandTrajectory, in_tick=True, prepare=_command_goal)
def _command(
    simulation: Simulation, request: CommandTrajectory, goal: TrajectoryGoal
) -> None:
    simulation.core.command_trajectory(request.controller, goal)


@handles(ScaleTrajectory, in_tick=True)
def _scale(simulation: Simulation, request: ScaleTrajectory) -> None:
    simulation.core.scale_trajectory(request.controller, request.factor)


def _import_planner(simulation: Simulation, request: Request[Any]) -> None:
    """Import the planner: slow the first time, so not in the thread of the tick."""
    import_planner()


@handles(MoveJoints, in_tick=True, prepare=_import_planner)
def _move(
    simulation: Simulation, request: MoveJoints, prepared: None
) -> tuple[GoalStarted, ...]:
    core, positions, controller = simulation.core, request.positions, request.controller
    goals: tuple[Goal, ...]
    if request.duration is None:
        goals = core.move_joints(positions, request.speed, controller)
    else:
        goals = (core.move_joints_within(positions, request.duration, controller),)
    return tuple(started(simulation, goal) for goal in goals)


@handles(SteerJoints, in_tick=True, prepare=_import_planner)
def _steer(simulation: Simulation, request: SteerJoints, prepared: None) -> None:
    simulation.core.steer(request.controller, request.positions, request.speed)


@handles(PoseJoints)
def _pose(simulation: Simulation, request: PoseJoints) -> None:
    raise ControlError(
        "joints are set directly in `tool0 view` only; in a simulation, steer a "
        "trajectory controller"
    )


@handles(CommandGripper, in_tick=True)
def _command_gripper(simulation: Simulation, request: CommandGripper) -> GoalStarted:
    grip = request.grip
    goal = simulation.core.command_gripper(
        request.controller,
        request.position,
        request.max_effort,
        None if grip is None else drive_limits(simulation, grip),
        max_velocity=request.max_velocity,
    )
    return started(simulation, goal)


handles(CommandJoints, in_tick=True)(
    lambda sim, request: sim.core.command_joints(request.controller, request.values)
)


@handles(CancelGoal, in_tick=True)
def _cancel(simulation: Simulation, request: CancelGoal) -> None:
    goal = simulation.goals.find(request.goal)
    if not simulation.program_runs.cancel(goal):
        simulation.core.cancel(goal)


handles(ReadGoal)(lambda sim, request: sim.goals.find(request.goal).status)


# ---- named poses ------------------------------------------------------------------


class ListPoses(Request[dict[str, NamedPose]], frozen=True):
    """The robot's own poses and the saved ones, by name."""


class SavePose(Request[None], frozen=True):
    """Save the measured positions of the driven joints on the simulation's machine."""

    name: Name
    robot: Name | None = None
    """Only the joints of this robot, and a saved pose of that name keeps those of
    others; all joints, if left out."""


class DeletePose(Request[None], frozen=True):
    """Delete a saved pose; the robot's own poses stay."""

    name: Name


class GoToPose(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move the joints of a named pose there, as ``MoveJoints`` does.

    A pose with joints of an arm does not move its gripper, which may hold something; a
    pose with joints of grippers only, such as ``open``, moves those.
    """

    name: Name
    robot: Name | None = None
    """Only the joints of this robot; of all robots, if left out."""
    speed: SpeedScale = 0.5


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
    return answer(simulation, MoveJoints(positions=positions, speed=request.speed))


# ---- the controllers themselves -----------------------------------------------------

Names = Annotated[tuple[Name, ...], Meta(max_length=100)]


class ListControllers(Request[tuple[ControllerStatus, ...]], frozen=True):
    """Every loaded controller with its state and claims."""


class LoadController(Request[None], frozen=True):
    """Load a controller: of the bring-up's configuration, or of files for ROS 2."""

    name: Name
    type: Name | None = None
    """Its type, if the files do not say it; as the manager's ``<name>.type``."""
    files: Annotated[tuple[str, ...], Meta(max_length=100)] = ()
    """YAML files on the simulation's machine, as ``<name>.params_file``; the bring-up's
    configuration, if left out together with the type."""
    configure: bool = True
    """Whether it is configured at once; a controller of ROS 1 always is."""


class ConfigureController(Request[None], frozen=True):
    """Check the parameters of a loaded controller: it can be started then."""

    name: Name


class CleanupController(Request[None], frozen=True):
    """Make an inactive controller of ROS 2 unconfigured again."""

    name: Name


class ControllerTypeInfo(Struct, frozen=True, kw_only=True):
    """A type of controllers that can be loaded."""

    name: str
    """``joint_trajectory_controller/JointTrajectoryController``"""
    base: str
    """The C++ class that ROS reports as its base."""


class ListControllerTypes(Request[tuple[ControllerTypeInfo, ...]], frozen=True):
    """Every type of controller that can be loaded."""


class LoadControllerWith(Request[None], frozen=True):
    """Load a controller with the given parameters."""

    unchecked = ("config",)

    name: Name
    config: ControllerConfig | None = None
    """The bring-up's configuration, if left out."""
    configure: bool = True


class UnloadController(Request[None], frozen=True):
    """Unload a controller that is not running."""

    name: Name


class SwitchControllers(Request[None], frozen=True):
    """Stop and start controllers at one instant."""

    start: Names = ()
    stop: Names = ()
    strict: bool = True
    """Whether one impossible change rejects all; otherwise it is skipped."""


class ReadController(Request[TrajectoryState], frozen=True):
    """Desired, actual and error of a trajectory controller."""

    controller: Name


class QueryState(Request[JointsMotion], frozen=True):
    """The setpoint of a trajectory controller at a time."""

    controller: Name
    time: float | None = None
    """Simulated time [s]; now, if left out."""


class ReadGains(Request[dict[str, Gains]], frozen=True):
    """The PID gains of each joint of a controller; none where it has no PID."""

    controller: Name


class SetGains(Request[Gains], frozen=True):
    """Change PID gains of one joint; the response is all of them.

    Gains left out keep their values.  A running controller continues with the new
    gains, and the contribution of its integral does not jump.  They hold until the
    controller is unloaded; no file changes.
    """

    controller: Name
    joint: Name
    p: float | None = None
    """Command per position error: [N·m/rad | N/m] for an effort controller."""
    i: float | None = None
    """Command per position error and second."""
    d: float | None = None
    """Command per velocity error."""
    i_clamp: Annotated[float, Meta(ge=0.0)] | None = None
    """Largest contribution of the integral in either direction: [N·m | N] for an effort
    controller."""
    antiwindup: bool | None = None
    """Whether the integral itself is clamped, not only its contribution."""


class ReadControllerParameters(Request[dict[str, Any]], frozen=True):
    """Every parameter of a loaded controller by dotted name, defaults included."""

    controller: Name


class SetControllerParameters(Request[None], frozen=True):
    """Change parameters of a loaded controller that may change while it runs.

    They hold until the controller is unloaded; no file changes.
    """

    controller: Name
    parameters: dict[str, bool | int | float | str]
    """By dotted name: ``constraints.goal_time``."""


class ReadControllerSpec(Request[ControllerSpec], frozen=True):
    """The parameters that a controller was loaded with."""

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
        config = ControllerConfig.from_files(map(Path, request.files))
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
        sim.core.trajectory_controller(request.controller).setpoint().state()
    )
)


@handles(QueryState, in_tick=True, publishes=False)
def _query(simulation: Simulation, request: QueryState) -> JointsMotion:
    core = simulation.core
    time = core.time if request.time is None else request.time
    return core.trajectory_controller(request.controller).query_state(time)


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


handles(ReadControllerParameters, in_tick=True, publishes=False)(
    lambda sim, request: dict(sim.core.manager.parameters(request.controller))
)
handles(SetControllerParameters, in_tick=True)(
    lambda sim, request: sim.core.manager.set_parameters(
        request.controller, request.parameters
    )
)
handles(ReadControllerSpec, in_tick=True, publishes=False, local=True)(
    lambda sim, request: sim.core.manager.spec(request.controller)
)
