"""Handlers of arm requests that refer to tool poses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tool0.control.controller_parts import rating
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import FLANGE
from tool0.description.posture import Branch, Solution
from tool0.description.transform import Transform
from tool0.description.units import SPEED
from tool0.errors import ControlError
from tool0.protocol.arm import (
    ArmInfo,
    ListArms,
    MoveLinear,
    MoveTo,
    ReadBranch,
    ReadToolPose,
    SolveInverseKinematics,
)
from tool0.protocol.goals import GoalStarted
from tool0.protocol.motion import MoveJoints
from tool0.protocol.trajectories import FollowTrajectory
from tool0.simulation.handlers.commanded import standing, trajectory_controller
from tool0.simulation.handlers.motion_checks import motion_plans
from tool0.simulation.handlers.table import answer, handles
from tool0.simulation.paths import trajectory_points
from tool0.simulation.simulation import Simulation
from tool0.simulation.tool_poses import pose_in_base, tool_in_flange

if TYPE_CHECKING:
    from tool0.kinematics.chain import ArmChain
    from tool0.kinematics.inverse import InverseKinematics
    from tool0.motion.path import Path


_AFTER_ANY_MOTION = 1e6
"""Time after which every motion is assumed to have ended [s]."""
AT_REST = 1e-6
"""Velocity and acceleration below which a joint is considered to be at rest [rad/s,
rad/s²], and largest distance of a joint at rest from its target [rad]."""


@handles(ListArms)
def _list(simulation: Simulation, request: ListArms) -> tuple[ArmInfo, ...]:
    rated = {
        f"{robot.prefix}{FLANGE}": rating(robot.arm, "payload")
        for robot in simulation.description.robots
    }
    return tuple(
        ArmInfo(
            name=name,
            base=chain.base,
            tip=chain.tip,
            joint_names=chain.joint_names,
            rated_payload=rated.get(chain.tip),
        )
        for name, chain in simulation.arms.items()
    )


@handles(ReadToolPose)
def _pose(simulation: Simulation, request: ReadToolPose) -> Transform:
    from tool0.description.transform import from_matrix

    chain, model = simulation.arm(request.arm), simulation.description.model
    found = link_poses(model, simulation.snapshot.positions)
    T_tip_tool = from_matrix(tool_in_flange(model, chain, request))
    T_root_tool = found[chain.tip] @ T_tip_tool
    if request.relative_to is None:
        return T_root_tool
    return found[model.link(request.relative_to).name].inverse() @ T_root_tool


@handles(ReadBranch)
def _branch(simulation: Simulation, request: ReadBranch) -> Branch:
    import numpy as np

    chain, measured = simulation.arm(request.arm), simulation.snapshot.positions
    q = np.array([measured[name] for name in chain.joint_names])
    return _kinematics(chain).branch(q)


@handles(SolveInverseKinematics)
def _solve(
    simulation: Simulation, request: SolveInverseKinematics | MoveTo
) -> tuple[Solution, ...]:
    import numpy as np

    chain = simulation.arm(request.arm)
    names = chain.joint_names
    positions = standing(simulation, request.arm)
    reference = np.array([positions[name] for name in names])
    for joint, position in request.near.items():
        if joint not in names:
            raise ControlError(
                f"near: '{joint}' is not a joint of the arm: {', '.join(names)}"
            )
        reference[names.index(joint)] = position
    model = simulation.description.model
    T_base_tool = pose_in_base(model, chain, request, positions)
    T_base_tip = T_base_tool @ np.linalg.inv(tool_in_flange(model, chain, request))
    return _kinematics(chain).solutions(T_base_tip, reference, request.branch)


@handles(MoveTo)
def _move_to(simulation: Simulation, request: MoveTo) -> GoalStarted:
    controller = trajectory_controller(simulation, simulation.arm(request.arm))
    positions = dict(_solve(simulation, request)[0].positions)
    motion = MoveJoints(
        positions=positions,
        speed=request.speed,
        controller=controller,
        collision=request.collision,
    )
    (started,) = answer(simulation, motion)
    return started


@handles(MoveLinear)
def _move_linear(simulation: Simulation, request: MoveLinear) -> GoalStarted:
    SPEED.require_plausible(request.speed, "speed")
    chain = simulation.arm(request.arm)
    controller = trajectory_controller(simulation, chain)
    resting = _at_rest(simulation, controller)
    positions = {**simulation.snapshot.positions, **resting}
    path = line_of(simulation, request, positions)
    if request.collision == "refuse":
        motion_plans(simulation).require_free_path(path, positions)
    if _at_rest(simulation, controller) != resting:
        raise ControlError("the arm was moved while its line was planned")
    trajectory = FollowTrajectory(
        controller=controller,
        points=tuple(trajectory_points(path.beside(resting))),
        joint_names=tuple(resting),
    )
    return answer(simulation, trajectory)


def line_of(
    simulation: Simulation, request: MoveLinear, positions: Mapping[str, float]
) -> Path:
    """Return a straight-line motion of a tool, starting at joint ``positions``."""
    import numpy as np

    from tool0.motion.linear import plan_line

    chain, model = simulation.arm(request.arm), simulation.description.model
    return plan_line(
        _kinematics(chain),
        np.array([positions[name] for name in chain.joint_names]),
        pose_in_base(model, chain, request, positions),
        tool_in_flange(model, chain, request),
        T_root_base=link_poses(model, positions)[chain.base].matrix,
        speed=request.speed,
        acceleration=request.acceleration,
        angular_speed=request.angular_speed,
    )


def _kinematics(chain: ArmChain) -> InverseKinematics:
    """Return an arm's inverse kinematics; raise ControlError for non-UR geometry."""
    from tool0.kinematics.inverse import InverseKinematics

    return InverseKinematics(chain)


def _at_rest(simulation: Simulation, name: str) -> Mapping[str, float]:
    """Return the resting positions of a controller's joints, or raise ControlError."""
    executor = simulation.executor

    def read() -> Any:
        controller = executor.trajectory_controller(name)
        state = controller.setpoint().state()
        return state, controller.query_state(state.time + _AFTER_ANY_MOTION)

    state, end = simulation.loop.call(read, publishes=False)
    now = state.desired
    still = max(map(abs, (*now.velocities, *now.accelerations))) < AT_REST
    there = zip(now.positions, end.positions, strict=True)
    if not still or max(abs(q - last) for q, last in there) > AT_REST:
        raise ControlError(
            f"move_linear starts at rest, and '{name}' is moving; wait for its goal, "
            "or cancel that"
        )
    return dict(zip(state.joint_names, now.positions, strict=True))
