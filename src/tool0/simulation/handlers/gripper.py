"""Handlers of the requests to a parallel gripper."""

from __future__ import annotations

from dataclasses import replace

from tool0.description.model import ParallelGripper
from tool0.description.parts import find_grippers
from tool0.errors import ControlError, ModelError, did_you_mean
from tool0.motion.gripper import opening_path
from tool0.protocol.controllers import Role, start_command, why_not_driven
from tool0.protocol.goals import GoalStarted
from tool0.protocol.gripper import Grip, ReactivateGripper, ReadGripper
from tool0.protocol.motion import CommandGripper, GripLimits
from tool0.protocol.trajectories import FollowTrajectory, TrajectoryPoint
from tool0.sensing.grasp import judge, wanted_openings
from tool0.simulation.handlers.motion import drive_limits
from tool0.simulation.handlers.table import answer, handles
from tool0.simulation.paths import trajectory_points
from tool0.simulation.simulation import Simulation

SQUEEZED = 0.001
"""Distance by which the commanded opening must be below the measured opening for the
gripper to be considered squeezing [m]."""


@handles(Grip)
def _grip(simulation: Simulation, request: Grip) -> GoalStarted:
    gripper = simulation.gripper(request.gripper)
    opening = _opening(simulation, gripper, request)
    target, joint = gripper.position(opening), gripper.joint
    speed = gripper.speed[1] if request.speed is None else request.speed
    force = request.force
    if force is None and request.effort is None:
        force = gripper.force[1]
    limits = GripLimits(
        gripper=request.gripper, speed=speed, force=force, effort=request.effort
    )
    drive_limits(simulation, limits)  # raises an error if a limit is out of range
    for status in simulation.snapshot.controllers:
        if not status.is_running or joint not in status.joints:
            continue
        if status.role is Role.GRIPPER:
            effort = request.effort
            if request.force is not None:
                effort = simulation.joint_limits[joint].effort
            command = CommandGripper(
                controller=status.name, position=target, max_effort=effort, grip=limits
            )
            return answer(simulation, command)
        if status.role is Role.TRAJECTORY:
            trajectory = FollowTrajectory(
                controller=status.name,
                points=tuple(_plan(simulation, gripper, opening, speed)),
                joint_names=(joint,),
                grip=limits,
            )
            return answer(simulation, trajectory)
    roles = (Role.TRAJECTORY, Role.GRIPPER)
    raise ControlError(why_not_driven(simulation.snapshot.controllers, [joint], roles))


@handles(ReactivateGripper)
def _reactivate(simulation: Simulation, request: ReactivateGripper) -> GoalStarted:
    name, statuses = request.controller, simulation.snapshot.controllers
    status = next((item for item in statuses if item.name == name), None)
    if status is None:
        names = [item.name for item in statuses]
        raise ControlError(
            f"controller '{name}' is not loaded{did_you_mean(name, names)}"
        )
    if not status.is_running:
        raise ControlError(
            f"'{name}' is {status.state}; start it with {start_command(name)}"
        )
    claimed = next(iter(status.command_interfaces), "")
    prefix, mark, _ = claimed.partition("reactivate_gripper/")
    if not mark:
        raise ControlError(f"'{name}' activates no gripper: it is {status.type}")
    for gripper, geometry in find_grippers(simulation.description.model).items():
        if geometry.joint.startswith(prefix):
            opened = Grip(gripper=gripper, opening=geometry.max_opening)
            return answer(simulation, opened)
    raise ControlError(f"'{name}' finds no gripper whose joint begins with '{prefix}'")


handles(ReadGripper)(
    lambda sim, request: judge(sim.gripper(request.gripper), sim.bus.history())
)


def _opening(simulation: Simulation, gripper: ParallelGripper, request: Grip) -> float:
    """Return the requested opening [m]."""
    unit = next(iter(gripper.quantity.units))
    if (request.opening is None) == (request.position is None):
        raise ControlError(f"grip: give either 'opening' [m] or 'position' [{unit}]")
    if request.opening is not None:
        return request.opening
    # When the joint is at an end stop, the opening may be slightly beyond the gripper's
    # range.
    position, limits = request.position or 0.0, simulation.joint_limits[gripper.joint]
    if not limits.lower <= position <= limits.upper:
        raise ModelError(
            f"gripper position {position} {unit} is outside "
            f"[{limits.lower:.4f}, {limits.upper:.4f}] {unit}"
        )
    return min(max(gripper.opening(position), 0.0), gripper.max_opening)


def _plan(
    simulation: Simulation, gripper: ParallelGripper, end: float, speed: float
) -> list[TrajectoryPoint]:
    """Return the motion from the current opening to the opening ``end`` [m].

    If the gripper is squeezing and the motion closes it further, the squeeze continues
    without a release.  For an opening motion, the setpoint starts at the measured
    opening.  The current setpoint of the controller is a smaller opening, so the
    gripper would otherwise continue to squeeze with the full force of the new goal.
    """
    snapshot = simulation.snapshot
    here = snapshot.position[snapshot.joint_names.index(gripper.joint)]
    now = max(0.0, gripper.opening(here))
    wanted = wanted_openings(snapshot, gripper)
    ahead = 0.0 if wanted is None else wanted[0] - now
    if ahead * (end - now) > 0.0:
        start = end if abs(ahead) > abs(end - now) else now + ahead
        return trajectory_points(opening_path(gripper, start, end, speed))
    motion = trajectory_points(opening_path(gripper, now, end, speed))
    if abs(ahead) <= SQUEEZED:
        return motion
    at_once = simulation.loop.control_period
    later = [
        replace(point, time_from_start=point.time_from_start + at_once)
        for point in motion
    ]
    return [TrajectoryPoint([here], [0.0], time_from_start=at_once), *later]
