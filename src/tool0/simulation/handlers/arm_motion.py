"""Handlers of the requests to an arm that a program moves."""

from __future__ import annotations

import math
from typing import Any

from tool0.control.arm.path import ArmPath
from tool0.errors import RequestError
from tool0.protocol.arm_motion import (
    SILENCE,
    EndForceMode,
    EndFreedrive,
    ExecutePath,
    ReadArmMotion,
    ReturnArm,
    ServoJoints,
    SpeedJoints,
    SpeedTool,
    StartForceMode,
    StartFreedrive,
    StopArm,
    TakeArm,
    ZeroWrench,
)
from tool0.protocol.request import ArmRequest
from tool0.protocol.state import ArmSample
from tool0.protocol.state_message import filled
from tool0.simulation.handlers.stream_watch import StreamWatch
from tool0.simulation.handlers.table import handles
from tool0.simulation.simulation import Simulation


@handles(TakeArm, in_tick=True)
def _take(simulation: Simulation, request: TakeArm) -> None:
    simulation.core.take_arm(request.arm, request.by, protected=request.protected)
    _forget_stream(simulation, request)


@handles(ReturnArm, in_tick=True)
def _return(simulation: Simulation, request: ReturnArm) -> None:
    core, by = simulation.core, request.by
    if by is None or core.control_boxes.find(request.arm).taken_by == by:
        core.arm_motions.release(request.arm, core.state)
        _forget_stream(simulation, request)


def _forget_stream(simulation: Simulation, request: ArmRequest[Any]) -> None:
    arm = simulation.core.control_boxes.find(request.arm).arm
    simulation.service(StreamWatch).forget(arm)


def _path(simulation: Simulation, request: ExecutePath) -> ArmPath:
    if (request.after is None) != (request.at is None):
        raise RequestError("execute_path", "'after' and 'at' need each other")
    core = simulation.core
    arm = core.control_boxes.find(request.arm).arm
    return ArmPath.of(
        core.arm_motions.specs[arm].joint_models,
        request.times,
        request.positions,
        request.velocities,
        request.accelerations,
    )


@handles(ExecutePath, in_tick=True, prepare=_path)
def _execute(simulation: Simulation, request: ExecutePath, path: ArmPath) -> int:
    core = simulation.core
    arm = core.control_boxes.find(request.arm).arm
    number = core.arm_motions.execute(
        arm, path, core.time, after=request.after, at=request.at
    )
    _forget_stream(simulation, request)
    return number


@handles(StopArm, in_tick=True)
def _stop(simulation: Simulation, request: StopArm) -> None:
    core = simulation.core
    core.arm_motions.find_to_stop(request.arm).stop_motion(
        request.deceleration, core.time, along_path=request.along_path
    )
    _forget_stream(simulation, request)


def _admit(
    simulation: Simulation, request: ServoJoints | SpeedJoints | SpeedTool
) -> None:
    """Refuse what continues a stream that has ended."""
    if not simulation.loop.is_realtime:
        return
    timeout, is_rest = request.timeout, False
    match request:
        case SpeedJoints(velocities=speeds) | SpeedTool(twist=speeds):
            is_rest = not any(speeds)
            if timeout is None and not request.duration:
                timeout = SILENCE
    arm = simulation.core.control_boxes.find(request.arm).arm
    simulation.service(StreamWatch).admit(arm, timeout, is_rest=is_rest)


@handles(ReadArmMotion)
def _read(simulation: Simulation, request: ReadArmMotion) -> ArmSample:
    snapshot = simulation.loop.snapshot_with_arms()
    arm = simulation.core.control_boxes.find(request.arm).arm
    return filled(snapshot, snapshot.arms[arm])


handles(ZeroWrench, in_tick=True)(
    lambda sim, request: sim.core.zero_wrench(request.arm)
)


@handles(ServoJoints, in_tick=True, publishes=False, prepare=_admit)
def _servo(simulation: Simulation, request: ServoJoints, admitted: None) -> None:
    core = simulation.core
    controller = core.arm_motions.find(request.arm)
    controller.require_positions(request.positions, core.time)
    controller.servo(core.time).aim(
        request.positions, lookahead_time=request.lookahead_time, gain=request.gain
    )


@handles(SpeedJoints, in_tick=True, publishes=False, prepare=_admit)
def _speed_joints(simulation: Simulation, request: SpeedJoints, admitted: None) -> None:
    core = simulation.core
    controller = core.arm_motions.find(request.arm)
    controller.require_velocities(request.velocities)
    controller.speed(core.time).aim(
        request.velocities,
        request.acceleration,
        until=core.time + (request.duration or math.inf),
    )


@handles(SpeedTool, in_tick=True, publishes=False, prepare=_admit)
def _speed_tool(simulation: Simulation, request: SpeedTool, admitted: None) -> None:
    import numpy as np

    core = simulation.core
    core.arm_motions.find(request.arm).speed(core.time).aim(
        request.twist,
        request.acceleration,
        until=core.time + (request.duration or math.inf),
        lever=np.array(request.tcp[:3]),
    )


@handles(StartForceMode, in_tick=True)
def _start_force_mode(simulation: Simulation, request: StartForceMode) -> None:
    import numpy as np

    from tool0.control.arm.compliance import ComplianceTask, force_damping
    from tool0.description.transform_arrays import matrix_of

    core = simulation.core
    task = ComplianceTask(
        frame=matrix_of(request.frame),
        free=np.array(request.selection),
        wrench=np.array(request.wrench),
        kind=request.kind,
        limits=np.array(request.limits),
        lever=np.array(request.tcp[:3]),
        damping=force_damping(request.damping, request.gain_scaling),
    )
    core.arm_motions.comply(request.arm, task, core.state)


@handles(StartFreedrive, in_tick=True)
def _start_freedrive(simulation: Simulation, request: StartFreedrive) -> None:
    import numpy as np

    from tool0.control.arm.compliance import FREEDRIVE_DAMPING, ComplianceTask
    from tool0.description.transform_arrays import matrix_of

    core = simulation.core
    task = ComplianceTask(
        frame=matrix_of(request.frame),
        free=np.array(request.axes),
        wrench=np.zeros(6),
        limits=np.full(6, 100.0),
        lever=np.array(core.control_boxes.find(request.arm).tcp[:3]),
        damping=FREEDRIVE_DAMPING,
        is_freedrive=True,
    )
    core.arm_motions.comply(request.arm, task, core.state)


def _end(simulation: Simulation, request: EndForceMode | EndFreedrive) -> None:
    core = simulation.core
    is_freedrive = isinstance(request, EndFreedrive)
    core.arm_motions.stiffen(request.arm, core.state, is_freedrive=is_freedrive)


handles(EndForceMode, in_tick=True)(_end)
handles(EndFreedrive, in_tick=True)(_end)
