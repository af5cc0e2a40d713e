"""Handlers of the requests to an arm that a program controls."""

from __future__ import annotations

from typing import Any

from tool0.control.arm.path import ArmPath
from tool0.control.arm.torque import TorqueCommand
from tool0.errors import RequestError
from tool0.protocol.arm_motion import (
    SILENCE,
    DriveTorques,
    EndForceMode,
    EndFreedrive,
    EndTorques,
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
    simulation.executor.take_arm(request.arm, request.by, protected=request.protected)
    _forget_stream(simulation, request)


@handles(ReturnArm, in_tick=True)
def _return(simulation: Simulation, request: ReturnArm) -> None:
    if simulation.executor.release_arm(request.arm, request.by):
        _forget_stream(simulation, request)


def _forget_stream(simulation: Simulation, request: ArmRequest[Any]) -> None:
    arm = simulation.core.arms.find(request.arm)
    simulation.service(StreamWatch).forget(arm.name)


def _path(simulation: Simulation, request: ExecutePath) -> ArmPath:
    if (request.after is None) != (request.at is None):
        raise RequestError("execute_path", "'after' and 'at' need each other")
    return ArmPath.of(
        simulation.core.arms.find(request.arm).motion.spec.joint_models,
        request.times,
        request.positions,
        request.velocities,
        request.accelerations,
    )


@handles(ExecutePath, in_tick=True, prepare=_path)
def _execute(simulation: Simulation, request: ExecutePath, path: ArmPath) -> int:
    number = simulation.executor.execute_path(
        request.arm, path, after=request.after, at=request.at
    )
    _forget_stream(simulation, request)
    return number


@handles(StopArm, in_tick=True)
def _stop(simulation: Simulation, request: StopArm) -> None:
    simulation.executor.stop_arm(
        request.arm, request.deceleration, along_path=request.along_path
    )
    _forget_stream(simulation, request)


def _admit(
    simulation: Simulation, request: ServoJoints | SpeedJoints | SpeedTool
) -> None:
    """Reject setpoints of a stream that has already ended."""
    if not simulation.loop.is_realtime:
        return
    timeout, is_rest = request.timeout, False
    match request:
        case SpeedJoints(velocities=speeds) | SpeedTool(twist=speeds):
            is_rest = not any(speeds)
            if timeout is None and not request.duration:
                timeout = SILENCE
    arm = simulation.core.arms.find(request.arm)
    simulation.service(StreamWatch).admit(arm.name, timeout, is_rest=is_rest)


@handles(ReadArmMotion)
def _read(simulation: Simulation, request: ReadArmMotion) -> ArmSample:
    snapshot = simulation.loop.snapshot_with_arms()
    arm = simulation.core.arms.find(request.arm)
    return filled(snapshot, snapshot.arms[arm.name])


handles(ZeroWrench, in_tick=True)(
    lambda sim, request: sim.core.zero_wrench(request.arm)
)


@handles(ServoJoints, in_tick=True, publishes=False, prepare=_admit)
def _servo(simulation: Simulation, request: ServoJoints, admitted: None) -> None:
    simulation.executor.servo_joints(
        request.arm,
        request.positions,
        lookahead_time=request.lookahead_time,
        gain=request.gain,
    )


@handles(SpeedJoints, in_tick=True, publishes=False, prepare=_admit)
def _speed_joints(simulation: Simulation, request: SpeedJoints, admitted: None) -> None:
    simulation.executor.speed_joints(
        request.arm, request.velocities, request.acceleration, request.duration
    )


@handles(SpeedTool, in_tick=True, publishes=False, prepare=_admit)
def _speed_tool(simulation: Simulation, request: SpeedTool, admitted: None) -> None:
    import numpy as np

    simulation.executor.speed_tool(
        request.arm,
        request.twist,
        request.acceleration,
        request.duration,
        lever=np.array(request.tcp[:3]),
    )


@handles(DriveTorques, in_tick=True, publishes=False)
def _drive_torques(simulation: Simulation, request: DriveTorques) -> None:
    command = TorqueCommand(
        torques=request.torques,
        viscous_scale=request.viscous_scale,
        coulomb_scale=request.coulomb_scale,
        until=simulation.core.time + request.duration,
    )
    simulation.executor.drive(request.arm, command)


handles(EndTorques, in_tick=True)(
    lambda sim, request: sim.executor.end_torques(request.arm)
)


@handles(StartForceMode, in_tick=True)
def _start_force_mode(simulation: Simulation, request: StartForceMode) -> None:
    import numpy as np

    from tool0.control.arm.compliance import ComplianceTask, force_damping
    from tool0.description.transform_arrays import matrix_of

    task = ComplianceTask(
        frame=matrix_of(request.frame),
        free=np.array(request.selection),
        wrench=np.array(request.wrench),
        kind=request.kind,
        limits=np.array(request.limits),
        lever=np.array(request.tcp[:3]),
        damping=force_damping(request.damping, request.gain_scaling),
    )
    simulation.executor.start_compliance(request.arm, task, request.controller)


@handles(StartFreedrive, in_tick=True)
def _start_freedrive(simulation: Simulation, request: StartFreedrive) -> None:
    import numpy as np

    from tool0.control.arm.compliance import (
        FREEDRIVE_DAMPING,
        UNLIMITED,
        ComplianceTask,
    )
    from tool0.description.transform_arrays import matrix_of

    task = ComplianceTask(
        frame=matrix_of(request.frame),
        free=np.array(request.axes),
        wrench=np.zeros(6),
        limits=np.full(6, UNLIMITED),
        lever=np.array(simulation.core.arms.find(request.arm).box.state.tcp[:3]),
        damping=FREEDRIVE_DAMPING,
        is_freedrive=True,
    )
    simulation.executor.start_compliance(request.arm, task, request.controller)


def _end(simulation: Simulation, request: EndForceMode | EndFreedrive) -> None:
    simulation.executor.end_compliance(
        request.arm,
        request.controller,
        is_freedrive=isinstance(request, EndFreedrive),
    )


handles(EndForceMode, in_tick=True)(_end)
handles(EndFreedrive, in_tick=True)(_end)
