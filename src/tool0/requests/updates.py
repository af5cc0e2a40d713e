"""Control updates: the lean stream for programs that publish every one of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from tool0.errors import ControlError
from tool0.protocol.state import (
    ArmSample,
    ArmSetpoint,
    Snapshot,
)
from tool0.protocol.updates import (
    ArmUpdate,
    Motion,
    Six,
    SubscribeUpdates,
    UpdateMessage,
)
from tool0.requests.table import handles
from tool0.runtime.simulation import Simulation


def update_message(
    snapshot: Snapshot,
    before: Snapshot | None,
    motions: Collection[str],
    arms: Collection[str] = (),
) -> UpdateMessage:
    """Return a snapshot as it is sent, after ``before`` in a stream.

    ``motions`` names the controllers whose motions are sent, ``arms`` the arms.
    """
    more: dict[str, Any] = {}
    if before is None:
        more["joint_names"] = snapshot.joint_names
    if before is None or before.controllers is not snapshot.controllers:
        more["controllers"] = snapshot.controllers
    if before is None or before.control_boxes is not snapshot.control_boxes:
        more["control_boxes"] = snapshot.control_boxes
    if motions:
        more["command"] = snapshot.command
        more["motions"] = {
            name: _motion(snapshot, name)
            for name in motions
            if name in snapshot.controller_setpoints
        }
    if arms:
        more["arms"] = {
            name: arm_update(snapshot, snapshot.arms[name]) for name in arms
        }
    return UpdateMessage(
        time=snapshot.time,
        tick=snapshot.tick,
        position=snapshot.position,
        velocity=snapshot.velocity,
        effort=snapshot.effort,
        is_paused=snapshot.is_paused,
        is_stopped=snapshot.is_stopped,
        **more,
    )


def _motion(snapshot: Snapshot, controller: str) -> Motion:
    state = snapshot.controller_setpoints[controller].state()
    desired, actual, error = state.desired, state.actual, state.error
    return Motion(
        reference=(desired.positions, desired.velocities, desired.accelerations),
        feedback=(actual.positions, actual.velocities),
        error=(error.positions, error.velocities),
        time_from_start=actual.time_from_start,
        speed_scaling=state.speed_scaling,
    )


def arm_update(snapshot: Snapshot, sample: ArmSample) -> ArmUpdate:
    """Return an arm as its control box reports it."""
    q, qd, qdd = sample.setpoint or _setpoint(snapshot, sample.joint_names)
    return ArmUpdate(
        target_position=_six(q),
        target_velocity=_six(qd),
        target_acceleration=_six(qdd),
        mode=sample.mode,
        path=sample.path,
        path_time=sample.path_time,
        is_done=sample.is_done,
        force_mode=sample.force_mode,
        wrench=sample.wrench,
        failure=sample.failure,
    )


def _setpoint(snapshot: Snapshot, joints: tuple[str, ...]) -> ArmSetpoint:
    """Return the motion that a controller desires of these joints, or the measured."""
    for setpoint in snapshot.controller_setpoints.values():
        motion = setpoint.desired_motion(joints, snapshot.time)
        if motion is not None:
            return motion
    index = snapshot.joint_names.index
    return ArmSetpoint(
        tuple(snapshot.position[index(joint)] for joint in joints),
        tuple(snapshot.velocity[index(joint)] for joint in joints),
        (0.0,) * len(joints),
    )


def _six(values: Sequence[float]) -> Six:
    a, b, c, d, e, f = values
    return a, b, c, d, e, f


@handles(SubscribeUpdates)
def _only_on_connections(simulation: Simulation, request: SubscribeUpdates) -> None:
    raise ControlError("streams are for connections; here, use robot.subscribe()")
