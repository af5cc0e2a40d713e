"""Handlers of the requests for collision-free motions."""

from __future__ import annotations

from tool0.control.trajectory import TrajectoryGoal
from tool0.errors import ControlError
from tool0.protocol.arm import MoveLinear
from tool0.protocol.goals import GoalStarted
from tool0.protocol.planning import (
    CancelPlanning,
    Checked,
    CheckMotion,
    ExecutePlan,
    Plan,
    PlanMotion,
)
from tool0.protocol.request import Name, Request
from tool0.protocol.trajectories import Points, TrajectoryPoint
from tool0.simulation.handlers.arm import line_of
from tool0.simulation.handlers.commanded import standing, trajectory_controller
from tool0.simulation.handlers.motion import started
from tool0.simulation.handlers.motion_checks import motion_plans
from tool0.simulation.handlers.table import answer, handles
from tool0.simulation.simulation import Simulation


class StartPlan(Request[tuple[GoalStarted, ...]], frozen=True):
    """Start motions of several controllers in the same tick.

    A new contact stops the motions, unless the contact is with one of ``may_touch``.
    """

    unchecked = ("motions",)

    motions: tuple[tuple[Name, tuple[str, ...], Points], ...]
    """Motion of each controller: the name of the controller, the joints, and the
    points."""
    may_touch: tuple[str, ...] = ()
    carried: tuple[str, ...] = ()
    """Names of the objects that move with the arms."""


@handles(PlanMotion)
def _plan(simulation: Simulation, request: PlanMotion) -> Plan:
    positions = standing(simulation, *(target.arm for target in request.targets))
    return motion_plans(simulation).plan(request, positions)


handles(CancelPlanning)(lambda sim, _: motion_plans(sim).cancel())


@handles(CheckMotion)
def _check(simulation: Simulation, request: CheckMotion) -> Checked:
    target = request.target
    positions = standing(simulation, target.arm)
    line = None
    if request.linear:
        if target.pose is None:
            raise ControlError("a straight line of the tool needs a pose")
        move = MoveLinear(
            arm=target.arm,
            pose=target.pose,
            tip=target.tip,
            tool=target.tool,
            relative_to=target.relative_to,
        )
        line = line_of(simulation, move, positions)
    return motion_plans(simulation).check(request, positions, line)


@handles(ExecutePlan)
def _execute(simulation: Simulation, request: ExecutePlan) -> tuple[GoalStarted, ...]:
    plans = motion_plans(simulation)
    arms = [
        name
        for name, chain in simulation.arms.items()
        if chain.tip in plans.arms_of(request.number)
    ]
    kept = plans.to_execute(request.number, standing(simulation, *arms))
    plan = kept.plan
    motions = []
    for name in arms:
        chain = simulation.arm(name)
        columns = [plan.joint_names.index(joint) for joint in chain.joint_names]
        rows = zip(
            plan.times, plan.positions, plan.velocities, plan.accelerations, strict=True
        )
        points = tuple(
            TrajectoryPoint(
                [q[k] for k in columns],
                [qd[k] for k in columns],
                [qdd[k] for k in columns],
                time,
            )
            for time, q, qd, qdd in rows
            if time > 0.0
        )
        controller = trajectory_controller(simulation, chain)
        motions.append((controller, chain.joint_names, points))
    return answer(
        simulation,
        StartPlan(
            motions=tuple(motions),
            may_touch=tuple(sorted(kept.may_touch)),
            carried=tuple(sorted(kept.carried)),
        ),
    )


@handles(StartPlan, in_tick=True, local=True)
def _start(simulation: Simulation, request: StartPlan) -> tuple[GoalStarted, ...]:
    goals = simulation.executor.follow_together(
        {
            controller: TrajectoryGoal(points=points, joint_names=joints)
            for controller, joints, points in request.motions
        },
        may_touch=frozenset(request.may_touch),
        carried=frozenset(request.carried),
    )
    return tuple(started(simulation, goal) for goal in goals)
