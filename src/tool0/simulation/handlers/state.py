"""Handlers of the requests for the entire robot: state, time and safety."""

from __future__ import annotations

import logging
from dataclasses import replace
from functools import partial

from tool0.description.forward_kinematics import joint_positions, link_pose
from tool0.description.transform import Transform
from tool0.protocol.bus import WasFrozen
from tool0.protocol.goals import GoalStatus, Result
from tool0.protocol.notifications import frozen_text
from tool0.protocol.robot import (
    DescriptionInfo,
    LimitsInfo,
    ReadDescription,
    ReadInfo,
    ReadLinkPose,
    ReadSnapshot,
    ReadSummary,
    SimulationInfo,
)
from tool0.protocol.running import (
    EmergencyStop,
    Pause,
    Reset,
    Resume,
    Run,
    SetSpeed,
    Step,
    StopMotions,
)
from tool0.protocol.sent_description import description_info
from tool0.simulation.handlers.table import answer, handles
from tool0.simulation.simulation import Simulation

logger = logging.getLogger(__name__)


@handles(ReadInfo)
def _info(simulation: Simulation, request: ReadInfo) -> SimulationInfo:
    return SimulationInfo(
        engine=simulation.engine.name,
        control_period=simulation.loop.control_period,
        is_realtime=simulation.loop.is_realtime,
        spawn_z=simulation.spawn_z,
        ground=simulation.ground,
        grasp_assist=simulation.grasp_assist,
        joint_limits={
            name: LimitsInfo.of(limits)
            for name, limits in simulation.joint_limits.items()
        },
        defined_controllers=dict(simulation.defined_controllers),
        controller_roles={
            name: simulation.core.manager.dialect.role(kind)
            for name, kind in simulation.defined_controllers.items()
        },
        parameters=dict(simulation.parameters),
        warnings=tuple(map(str, simulation.warnings)),
    )


@handles(ReadDescription)
def _description(simulation: Simulation, request: ReadDescription) -> DescriptionInfo:
    return description_info(simulation.description, simulation.spawn_z)


handles(ReadSnapshot)(lambda sim, _: sim.snapshot)


@handles(ReadLinkPose)
def _link_pose(simulation: Simulation, request: ReadLinkPose) -> Transform:
    return link_pose(
        simulation.description.model,
        simulation.snapshot.positions,
        request.link,
        relative_to=request.relative_to,
    )


handles(ReadSummary)(lambda sim, _: sim.summary())


# ---- time and safety ----------------------------------------------------------------


handles(Pause, in_tick=True)(lambda sim, _: sim.loop.set_paused(True))
handles(Resume, in_tick=True)(lambda sim, _: sim.loop.set_paused(False))


@handles(Step, in_tick=True)
def _step(simulation: Simulation, request: Step) -> float:
    simulation.loop.step(request.ticks)
    return simulation.loop.time


handles(Run)(lambda sim, request: sim.loop.run(request.duration))
handles(SetSpeed, in_tick=True)(lambda sim, request: sim.loop.set_speed(request.factor))


def _check_pose(simulation: Simulation, request: Reset) -> None:
    """Raise PenetrationError if the requested pose causes impermissible contacts."""
    if not request.position or request.allow_penetration:
        return
    usual = simulation.setup.position
    position = joint_positions(simulation.description.model, request.position, usual)
    simulation.collisions.require_pose(position, usual, simulation.snapshot.scene)


@handles(Reset, in_tick=True, prepare=_check_pose)
def _reset(simulation: Simulation, request: Reset, checked: None) -> None:
    simulation.loop.reset(request.position, request.keep_time)


handles(EmergencyStop, in_tick=True)(
    lambda sim, request: sim.core.set_stopped(request.engaged)
)


@handles(StopMotions, in_tick=True)
def _stop_motions(simulation: Simulation, request: StopMotions) -> None:
    executor, runs = simulation.executor, simulation.program_runs
    for goal in simulation.goals.active():
        if not runs.cancel(goal):
            executor.cancel(goal)
    for arm in simulation.core.arms:
        if not runs.is_ending(arm.name):
            executor.release_arm(arm.name)
    executor.stop_controllers()


def stop_after_freezes(simulation: Simulation) -> None:
    """Stop every motion after the process was frozen.

    The client that commanded the motion, and the scene on which the command was based,
    may have changed while the process was frozen.
    """

    def stop(duration: float) -> None:
        text = frozen_text(duration)
        simulation.bus.announce(WasFrozen(duration, simulation.loop.time))
        logger.warning("%s", text)
        for goal in simulation.goals.active():
            goal.explain = partial(_because, text)
        simulation.program_runs.stop_all(text)
        answer(simulation, StopMotions())

    simulation.loop.when_frozen = stop


def _because(reason: str, result: Result) -> Result:
    """Return the result of a goal with the reason if the goal was preempted."""
    if result.status is not GoalStatus.PREEMPTED or result.error_string:
        return result
    return replace(result, error_string=reason)
