"""Requests to an arm that a program moves in place of ROS's controllers.

A program takes the arm, sends paths or streams, and gives it back.  The joints are in
the order from base to flange.
"""

from __future__ import annotations

import math
from typing import Annotated, Generic

from msgspec import Meta

from tool0.control.arm_path import ArmPath
from tool0.errors import RequestError
from tool0.requests.table import Name, Request, Response, handles
from tool0.runtime.simulation import Simulation

Row6 = tuple[float, float, float, float, float, float]
"""A number for each joint, from base to flange."""
Rows6 = tuple[Row6, ...]
Acceleration = Annotated[float, Meta(gt=0.0, le=1000.0)]
"""[rad/s², m/s²]"""
Duration = Annotated[float, Meta(ge=0.0)]
"""[s]"""
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

    An arm that is taken already only gets the name of the program.
    """

    by: Name
    """The program, for people."""


class ReturnArm(_OfArm[None], frozen=True):
    """Stop an arm, and start its controllers again once it is at rest."""


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
    tcp: Row6 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """The TCP in the flange, with a rotation vector [m, rad]."""


class ZeroWrench(_OfArm[None], frozen=True):
    """Let the wrench that updates have of an arm be 0 now: tare."""


@handles(TakeArm, in_tick=True)
def _take(simulation: Simulation, request: TakeArm) -> None:
    simulation.core.take_arm(request.arm, request.by)


@handles(ReturnArm, in_tick=True)
def _return(simulation: Simulation, request: ReturnArm) -> None:
    core = simulation.core
    core.arm_motions.give_back(request.arm, core.state)


@handles(ExecutePath)
def _execute(simulation: Simulation, request: ExecutePath) -> int:
    if (request.after is None) != (request.at is None):
        raise RequestError("execute_path", "'after' and 'at' need each other")
    core, loop = simulation.core, simulation.loop
    arm = core.control_boxes.find(request.arm).arm
    path = ArmPath.of(
        core.arm_motions.specs[arm].joint_models,
        request.times,
        request.positions,
        request.velocities,
        request.accelerations,
    )
    return loop.call(
        lambda: core.arm_motions.execute(
            arm, path, core.time, after=request.after, at=request.at
        )
    )


@handles(StopArm, in_tick=True)
def _stop(simulation: Simulation, request: StopArm) -> None:
    core = simulation.core
    core.arm_motions.find(request.arm).stop_motion(
        request.deceleration, core.time, along_path=request.along_path
    )


handles(ZeroWrench, in_tick=True)(
    lambda sim, request: sim.core.zero_wrench(request.arm)
)


@handles(ServoJoints, in_tick=True, publishes=False, streamed=True)
def _servo(simulation: Simulation, request: ServoJoints) -> None:
    core = simulation.core
    controller = core.arm_motions.find(request.arm)
    controller.require_positions(request.positions)
    controller.servo(core.time).aim(
        request.positions, lookahead_time=request.lookahead_time, gain=request.gain
    )


@handles(SpeedJoints, in_tick=True, publishes=False, streamed=True)
def _speed_joints(simulation: Simulation, request: SpeedJoints) -> None:
    core = simulation.core
    controller = core.arm_motions.find(request.arm)
    controller.require_velocities(request.velocities)
    controller.speed(core.time).aim(
        request.velocities,
        request.acceleration,
        until=core.time + (request.duration or math.inf),
    )


@handles(SpeedTool, in_tick=True, publishes=False, streamed=True)
def _speed_tool(simulation: Simulation, request: SpeedTool) -> None:
    import numpy as np

    core = simulation.core
    core.arm_motions.find(request.arm).speed(core.time).aim(
        request.twist,
        request.acceleration,
        until=core.time + (request.duration or math.inf),
        lever=np.array(request.tcp[:3]),
    )
