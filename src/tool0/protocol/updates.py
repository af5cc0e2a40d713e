"""Streams of a connection: snapshots, control updates, and what the panel shows."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Annotated, Any, Literal, final

from msgspec import UNSET, Meta, Struct, UnsetType

from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.controllers import ControllerStatus
from tool0.protocol.request import Name, Request
from tool0.protocol.state import (
    MAX_SNAPSHOT_RATE,
    MIN_SNAPSHOT_RATE,
    ArmSample,
    ArmSetpoint,
    MotionMode,
    Snapshot,
)


class SubscribeUpdates(Request[None], frozen=True):
    """Receive control updates as ``update`` messages, and faults and resets.

    A second request replaces the first.  Up to four times real time, there are no more
    updates per second of wall time than ``rate``.  While time runs faster, or as fast
    as possible, there are 50 a second, the newest only: the simulation is not slowed
    down.
    """

    is_of_connection = True

    rate: Annotated[float, Meta(ge=MIN_SNAPSHOT_RATE, le=MAX_SNAPSHOT_RATE)] = (
        MAX_SNAPSHOT_RATE
    )
    """Updates per simulated second [Hz]."""
    motions: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """The trajectory controllers whose motion is sent."""
    arms: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """The arms whose setpoint and wrench are sent."""


Rows = tuple[tuple[float, ...], ...]

Six = tuple[float, float, float, float, float, float]
"""Of an arm's joints from base to flange, or a wrench: force above torque."""


class Motion(Struct, frozen=True, kw_only=True):
    """How a trajectory controller moves its joints, in its order."""

    reference: Rows
    """Desired positions, velocities and accelerations [rad | m] and per second."""
    feedback: Rows
    """Measured positions and velocities."""
    error: Rows
    """reference - feedback, of positions and velocities."""
    time_from_start: float
    """[s]"""
    speed_scaling: float
    """Trajectory time per simulated time."""


class ArmUpdate(Struct, frozen=True, kw_only=True):
    """An arm as its control box reports it."""

    target_position: Six
    """The setpoint of what moves the arm; measured, if nothing does [rad]."""
    target_velocity: Six
    """[rad/s]"""
    target_acceleration: Six
    """[rad/s²]"""
    mode: MotionMode
    """What moves it: ``free`` is a controller of ROS, or nothing."""
    path: int
    """Number of the last path; 0 before the first."""
    path_time: float
    """On that path [s]; it passes more slowly if the speed is scaled."""
    is_done: bool
    """Whether the path has arrived at its end, or the stop has ended: the setpoint is
    at rest.  Not after a failure."""
    force_mode: bool
    """Whether it pushes with a force; the setpoint is the motion without it."""
    wrench: Six
    """External force [N] and torque [N·m] on the tool at the flange, in its axes, less
    the payload and the tare."""
    failure: str = ""
    """Why the motion failed: the arm rests where it was, and accepts no motion until it
    is taken again.  Empty if it did not."""


@final
class UpdateMessage(Struct, frozen=True, kw_only=True, tag="update"):
    """The robot after one control update, in the order of ``joint_names``."""

    time: float
    """Simulated [s]."""
    tick: int
    position: tuple[float, ...]
    """[rad | m]"""
    velocity: tuple[float, ...]
    """[rad/s | m/s]"""
    effort: tuple[float, ...]
    """[N·m | N]"""
    is_paused: bool
    is_stopped: bool
    """Whether the emergency stop is engaged."""
    joint_names: tuple[str, ...] | UnsetType = UNSET
    """Only in the first message."""
    controllers: tuple[ControllerStatus, ...] | UnsetType = UNSET
    """Only when they changed."""
    control_boxes: tuple[ControlBoxState, ...] | UnsetType = UNSET
    """Only when one changed."""
    command: tuple[float, ...] | UnsetType = UNSET
    """The last command of each joint, in the unit of its interface; only with
    ``motions``."""
    motions: Mapping[str, Motion] | UnsetType = UNSET
    """Of the requested controllers that are running."""
    arms: Mapping[str, ArmUpdate] | UnsetType = UNSET
    """The requested ones, by name."""


@final
class LogMessage(Struct, frozen=True, kw_only=True, tag="log"):
    """A warning or an error of the simulation, for its users."""

    level: Literal["warning", "error"]
    message: str


class Subscribe(Request[None], frozen=True):
    """Receive every snapshot as a ``snapshot`` message, and events as they happen.

    A second request changes the rate.  A slow reader loses the oldest snapshots; the
    next one says how many.
    """

    is_of_connection = True

    rate: Annotated[float, Meta(ge=MIN_SNAPSHOT_RATE, le=MAX_SNAPSHOT_RATE)] = 125.0
    """Snapshots per simulated second [Hz]: the next divisor of the control rate."""


class Unsubscribe(Request[None], frozen=True):
    """Receive no more snapshots and events."""

    is_of_connection = True


class SubscribeView(Request[None], frozen=True):
    """Receive ``view``, ``scene``, ``status``, ``frame`` and ``notice``: the panel.

    Frames come at most 60 times a second of wall time, the newest only.  A second
    request changes what they have.
    """

    is_of_connection = True

    contacts: bool = False
    """Whether frames have the contacts and their forces."""
    wrenches: bool = False
    """Whether frames have the wrench on each tool."""


class ViewShown(Request[None], frozen=True):
    """Report that a page has drawn the robot; ``tool0 demo`` starts then."""

    is_of_connection = True


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
