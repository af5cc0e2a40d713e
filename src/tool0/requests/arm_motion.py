"""Requests to an arm that a program moves in place of ROS's controllers.

A program takes the arm, sends paths or streams, and gives it back.  The joints are in
the order from base to flange.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Generic, Literal

from msgspec import Meta

from tool0.control.arm_path import ArmPath
from tool0.errors import RequestError
from tool0.requests.stream_watch import SILENCE, StreamWatch
from tool0.requests.table import Name, Request, Response, handles
from tool0.requests.updates import ArmUpdate, arm_update
from tool0.runtime.simulation import Simulation

Row6 = tuple[float, float, float, float, float, float]
"""A number for each joint, from base to flange."""
Rows6 = tuple[Row6, ...]
ZERO_POSE: Row6 = (0.0,) * 6
Flags6 = tuple[bool, bool, bool, bool, bool, bool]
Limit = Annotated[float, Meta(gt=0.0, le=100.0)]
Limits6 = tuple[Limit, Limit, Limit, Limit, Limit, Limit]
Acceleration = Annotated[float, Meta(gt=0.0, le=1000.0)]
"""[rad/s², m/s²]"""
Duration = Annotated[float, Meta(ge=0.0)]
"""[s]"""
Timeout = Annotated[float, Meta(gt=0.0, le=1e6)]
"""[wall s]"""
PathNumber = Annotated[int, Meta(ge=1)]
PathTime = Annotated[float, Meta(ge=0.0)]
"""[s]"""
MOST_KNOTS = 100_000


class _OfArm(Request[Response], Generic[Response], frozen=True, kw_only=True):
    """The field of every request to an arm."""

    arm: str | None = None
    """As ``list_arms`` names it; the only one, if left out."""


class TakeArm(_OfArm[None], frozen=True):
    """Let a program move an arm: its controllers stop, and it holds still.

    An arm that is taken already only gets the name of the program, and may move again
    after a motion that failed, or the emergency stop.
    """

    by: Name
    """The program, for people."""
    protected: bool = False
    """Whether a motion that fails is a protective stop, as on a UR; otherwise the arm
    stays taken."""


class ReturnArm(_OfArm[None], frozen=True):
    """Stop an arm, and start its controllers again once it is at rest."""

    by: Name | None = None
    """Only if this program still moves it: nobody else who took it is stopped."""


class ExecutePath(_OfArm[int], frozen=True):
    """Follow a path of the joints; the response is its number, from 1 on.

    It starts now, with the setpoint, or replaces another path.  Between two knots the
    joints follow cubics, or quintics if there are accelerations.
    """

    unchecked = ("times", "positions", "velocities", "accelerations")

    times: Annotated[tuple[float, ...], Meta(min_length=1, max_length=MOST_KNOTS)]
    """Of the knots after the start [s], increasing.  A knot at 0 must be the setpoint,
    within 1e-6 rad and rad/s."""
    positions: Annotated[Rows6, Meta(max_length=MOST_KNOTS)]
    """[rad]"""
    velocities: Annotated[Rows6, Meta(max_length=MOST_KNOTS)]
    """[rad/s]; 0 at the last knot."""
    accelerations: Annotated[Rows6, Meta(max_length=MOST_KNOTS)] = ()
    """[rad/s²]"""
    after: PathNumber | None = None
    """The number of the path that it replaces; none, if left out."""
    at: PathTime | None = None
    """From which time of that path on [s]."""


class StopArm(_OfArm[None], frozen=True):
    """Ramp down to rest, from any motion."""

    deceleration: Acceleration = 2.0
    """Of the leading joint [rad/s²].  With ``along_path``, by how much the speed of the
    path changes in a second [1/s²]: 2 ends it within half a second."""
    along_path: bool = False
    """Whether an arm on a path stays on it."""


class ServoJoints(_OfArm[None], frozen=True):
    """Follow a target from now on: one of a stream, as URScript's ``servoj``.

    Without an id, every one is executed at the next tick.  The law is
    qdd = gain (target - (q + lookahead_time qd)), with the setpoint's q and qd, within
    the limits of the joints.  The speed slider scales the largest velocity.
    """

    positions: Row6
    """[rad]"""
    duration: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.002
    """Until the next target is expected [s]; the last one is held after it."""
    lookahead_time: Annotated[float, Meta(ge=0.03, le=0.2)] = 0.1
    """[s]"""
    gain: Annotated[float, Meta(ge=100.0, le=2000.0)] = 300.0
    """[1/s²]"""
    timeout: Timeout = SILENCE
    """In real time: if the next target of a stream does not come within this wall time,
    the stream has ended [s].  The arm stops, and follows no further target until it is
    stopped (``stop_arm``), follows a path or is taken again."""


class SpeedJoints(_OfArm[None], frozen=True):
    """Ramp to joint velocities, as URScript's ``speedj``.

    The speed slider scales them.
    """

    velocities: Row6
    """[rad/s]"""
    acceleration: Acceleration = 1.4
    """Of the leading joint [rad/s²]."""
    duration: Duration | None = None
    """After this time the arm ramps to rest [s]; never, if left out or 0."""
    timeout: Timeout | None = None
    """As for ``servo_joints``; 0.5 s without a ``duration``, otherwise none."""


class SpeedTool(_OfArm[None], frozen=True):
    """Ramp to a velocity of the tool, as URScript's ``speedl``.

    Where a joint would be too fast or reach its limit, the tool slows down on its way.
    """

    twist: Row6
    """Of the TCP, linear and angular, in the axes of the base [m/s, rad/s]."""
    acceleration: Acceleration = 1.2
    """[m/s²], and the same number in [rad/s²]."""
    duration: Duration | None = None
    """After this time the arm ramps to rest [s]; never, if left out or 0."""
    timeout: Timeout | None = None
    """As for ``servo_joints``; 0.5 s without a ``duration``, otherwise none."""
    tcp: Row6 = ZERO_POSE
    """The TCP in the flange, with a rotation vector [m, rad]."""


class StartForceMode(_OfArm[None], frozen=True):
    """Push with a force along some axes of a frame, as URScript's ``force_mode``.

    It is superimposed on what else the arm does; a second request replaces the first.
    The force is that which the tool applies to its environment at rest.  Motions and
    their setpoints do not show how far the arm gives way.
    """

    frame: Row6
    """In the base, with a rotation vector [m, rad]."""
    selection: Flags6
    """Which axes of the frame give way: x, y, z, and about them."""
    wrench: Row6
    """Along those [N, N·m]; the numbers of other axes do not count."""
    limits: Limits6
    """Largest speed along an axis that gives way [m/s, rad/s]; largest deviation from
    the motion along another that it resists with more force [m, rad]."""
    kind: Literal[1, 2, 3] = 2
    """1: the frame's y axis points from the TCP to the frame's origin.  2: the frame is
    as given.  3: its x axis is the TCP's velocity, projected onto its xy plane."""
    tcp: Row6 = ZERO_POSE
    """The TCP in the flange, with a rotation vector [m, rad]."""
    damping: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.005
    """As for ``force_mode_set_damping``: how soon an undriven motion decays."""
    gain_scaling: Annotated[float, Meta(gt=0.0, le=2.0)] = 1.0
    """As for ``force_mode_set_gain_scaling``: divides the damping."""


class EndForceMode(_OfArm[None], frozen=True):
    """End force mode: the arm stops where it is, and a path of it ends."""


class StartFreedrive(_OfArm[None], frozen=True):
    """Let the arm be moved by hand; it stays where it is left."""

    axes: Flags6 = (True,) * 6
    """Along and about which axes of the frame the tool gives way."""
    frame: Row6 = ZERO_POSE
    """In the base, with a rotation vector [m, rad]."""


class EndFreedrive(_OfArm[None], frozen=True):
    """Hold the arm where it is."""


class ReadArmMotion(_OfArm[ArmUpdate], frozen=True):
    """Setpoint, mode, path and wrench of an arm, as updates have them."""


class ZeroWrench(_OfArm[None], frozen=True):
    """Let the wrench that updates have of an arm be 0 now: tare."""


@handles(TakeArm, in_tick=True)
def _take(simulation: Simulation, request: TakeArm) -> None:
    simulation.core.take_arm(request.arm, request.by, protected=request.protected)
    _forget_stream(simulation, request)


@handles(ReturnArm, in_tick=True)
def _return(simulation: Simulation, request: ReturnArm) -> None:
    core, by = simulation.core, request.by
    if by is None or core.control_boxes.find(request.arm).taken_by == by:
        core.arm_motions.give_back(request.arm, core.state)
        _forget_stream(simulation, request)


def _forget_stream(simulation: Simulation, request: _OfArm[Any]) -> None:
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
def _read(simulation: Simulation, request: ReadArmMotion) -> ArmUpdate:
    snapshot = simulation.loop.snapshot_with_arms()
    arm = simulation.core.control_boxes.find(request.arm).arm
    return arm_update(snapshot, snapshot.arms[arm])


handles(ZeroWrench, in_tick=True)(
    lambda sim, request: sim.core.zero_wrench(request.arm)
)


@handles(ServoJoints, in_tick=True, publishes=False, streamed=True, prepare=_admit)
def _servo(simulation: Simulation, request: ServoJoints, admitted: None) -> None:
    core = simulation.core
    controller = core.arm_motions.find(request.arm)
    controller.require_positions(request.positions, core.time)
    controller.servo(core.time).aim(
        request.positions, lookahead_time=request.lookahead_time, gain=request.gain
    )


@handles(SpeedJoints, in_tick=True, publishes=False, streamed=True, prepare=_admit)
def _speed_joints(simulation: Simulation, request: SpeedJoints, admitted: None) -> None:
    core = simulation.core
    controller = core.arm_motions.find(request.arm)
    controller.require_velocities(request.velocities)
    controller.speed(core.time).aim(
        request.velocities,
        request.acceleration,
        until=core.time + (request.duration or math.inf),
    )


@handles(SpeedTool, in_tick=True, publishes=False, streamed=True, prepare=_admit)
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

    from tool0.control.arm_compliance import ComplianceTask, force_damping
    from tool0.kinematics.pose import matrix_of

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

    from tool0.control.arm_compliance import FREEDRIVE_DAMPING, ComplianceTask
    from tool0.kinematics.pose import matrix_of

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
