"""Requests to an arm that a program moves in place of ROS's controllers.

A program takes the arm, sends paths or streams, and releases it.  The joints are in
the order from base to flange.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Literal, Protocol

from msgspec import Meta

from tool0.protocol.request import ArmRequest, Name, Request
from tool0.protocol.state import ArmSample

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

Row6 = tuple[float, float, float, float, float, float]
"""A number for each joint, from base to flange."""

Rows6 = tuple[Row6, ...]

ZERO_POSE: Row6 = (0.0,) * 6

Flags6 = tuple[bool, bool, bool, bool, bool, bool]

Limit = Annotated[float, Meta(gt=0.0, le=100.0)]

Limits6 = tuple[Limit, Limit, Limit, Limit, Limit, Limit]

Acceleration = Annotated[float, Meta(gt=0.0, le=1000.0)]
"""Acceleration of the joints [rad/s²] or of the tool [m/s²]."""

Duration = Annotated[float, Meta(ge=0.0)]
"""Duration [s]."""

Timeout = Annotated[float, Meta(gt=0.0, le=1e6)]
"""Timeout in real time [wall s]."""

PathNumber = Annotated[int, Meta(ge=1)]

PathTime = Annotated[float, Meta(ge=0.0)]
"""Time on a path [s]."""

MOST_KNOTS = 100_000
SILENCE: Final = 0.5
"""Longest time between two commands of a stream [wall s], unless they say otherwise."""


class TakeArm(ArmRequest[None], frozen=True):
    """Take an arm for a program: its controllers stop, and it holds still.

    An arm that is taken already only gets the name of the program, and may move again
    after a motion that failed, or the emergency stop.
    """

    by: Name
    """Name of the program, shown to users."""
    protected: bool = False
    """Whether a motion that fails is a protective stop, as on a UR; otherwise the arm
    stays taken."""


class ReturnArm(ArmRequest[None], frozen=True):
    """Stop an arm, and start its controllers again once it is at rest."""

    by: Name | None = None
    """Program that must still move the arm: no other program that took it is
    stopped."""


class ExecutePath(ArmRequest[int], frozen=True):
    """Follow a path of the joints; the response is its number, from 1 on.

    It starts now, with the setpoint, or replaces another path.  Between two knots the
    joints follow cubics, or quintics if there are accelerations.
    """

    unchecked = ("times", "positions", "velocities", "accelerations")

    times: Annotated[tuple[float, ...], Meta(min_length=1, max_length=MOST_KNOTS)]
    """Times of the knots after the start [s], increasing.  A knot at 0 must be the
    setpoint, within 1e-6 rad and rad/s."""
    positions: Annotated[Rows6, Meta(max_length=MOST_KNOTS)]
    """Joint positions at the knots [rad], shape (n, 6)."""
    velocities: Annotated[Rows6, Meta(max_length=MOST_KNOTS)]
    """Joint velocities at the knots [rad/s], shape (n, 6); 0 at the last knot."""
    accelerations: Annotated[Rows6, Meta(max_length=MOST_KNOTS)] = ()
    """Joint accelerations at the knots [rad/s²], shape (n, 6), or empty."""
    after: PathNumber | None = None
    """The number of the path that it replaces; none, if left out."""
    at: PathTime | None = None
    """Time of that path from which this one replaces it [s]."""


class SampledPath(Protocol):
    """A planned path, such as ``motion.path.Path``."""

    @property
    def times(self) -> Array:
        """Times of the knots [s], increasing from 0, shape (n,)."""

    @property
    def positions(self) -> Array:
        """Joint positions [rad], shape (n, 6)."""

    @property
    def velocities(self) -> Array:
        """Joint velocities [rad/s], shape (n, 6)."""

    @property
    def accelerations(self) -> Array | None:
        """Joint accelerations [rad/s²], shape (n, 6); None between cubics."""


def path_request(
    arm: str | None,
    path: SampledPath,
    *,
    after: int | None = None,
    at: float | None = None,
) -> ExecutePath:
    """Return the request that a taken arm follows a path.

    ``after`` and ``at`` are those of the request.
    """
    accelerations = path.accelerations
    return ExecutePath(
        arm=arm,
        times=tuple(path.times.tolist()),
        positions=tuple(map(tuple, path.positions.tolist())),
        velocities=tuple(map(tuple, path.velocities.tolist())),
        accelerations=(
            () if accelerations is None else tuple(map(tuple, accelerations.tolist()))
        ),
        after=after,
        at=at,
    )


class StopArm(ArmRequest[None], frozen=True):
    """Ramp down to rest, from any motion."""

    deceleration: Acceleration = 2.0
    """Deceleration of the leading joint [rad/s²].  With ``along_path``, deceleration of
    the path's speed [1/s²]: 2 ends it within half a second."""
    along_path: bool = False
    """Whether an arm on a path stays on it."""


class ServoJoints(ArmRequest[None], frozen=True):
    """Follow a target from now on: one of a stream, as URScript's ``servoj``.

    Without an id, every one is executed at the next tick.  The law is
    qdd = gain (target - (q + lookahead_time qd)), with the setpoint's q and qd, within
    the limits of the joints.  The speed slider scales the largest velocity.
    """

    is_streamed = True

    positions: Row6
    """Joint positions to move to [rad], shape (6,)."""
    duration: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.002
    """Simulated time until the next target is expected [s]; the last one is held after
    it."""
    lookahead_time: Annotated[float, Meta(ge=0.03, le=0.2)] = 0.1
    """Lookahead time of the law [s]: longer is smoother, and lags more."""
    gain: Annotated[float, Meta(ge=100.0, le=2000.0)] = 300.0
    """Gain of the law [1/s²]."""
    timeout: Timeout = SILENCE
    """Longest wall time between two targets of a stream [s].  If the next one does not
    come within it, the stream has ended: the arm stops, and follows no further target
    until it is stopped (``stop_arm``), follows a path or is taken again."""


class SpeedJoints(ArmRequest[None], frozen=True):
    """Ramp to joint velocities, as URScript's ``speedj``.

    The speed slider scales them.
    """

    is_streamed = True

    velocities: Row6
    """Joint velocities [rad/s], shape (6,)."""
    acceleration: Acceleration = 1.4
    """Acceleration of the leading joint [rad/s²]."""
    duration: Duration | None = None
    """Time after which the arm ramps to rest [s]; never, if left out or 0."""
    timeout: Timeout | None = None
    """Longest wall time between two targets [s], as for ``servo_joints``; 0.5 s without
    a ``duration``, otherwise none."""


class SpeedTool(ArmRequest[None], frozen=True):
    """Ramp to a velocity of the tool, as URScript's ``speedl``.

    Where a joint would be too fast or reach its limit, the tool slows down on its way.
    """

    is_streamed = True

    twist: Row6
    """Velocity of the TCP, linear and angular, in the axes of the base [m/s, rad/s]."""
    acceleration: Acceleration = 1.2
    """Acceleration of the tool [m/s²], and with the same number of its turning
    [rad/s²]."""
    duration: Duration | None = None
    """Time after which the arm ramps to rest [s]; never, if left out or 0."""
    timeout: Timeout | None = None
    """Longest wall time between two targets [s], as for ``servo_joints``; 0.5 s without
    a ``duration``, otherwise none."""
    tcp: Row6 = ZERO_POSE
    """The TCP in the flange, with a rotation vector [m, rad]."""


Share = Annotated[float, Meta(ge=0.0, le=1.0)]

Shares6 = tuple[Share, Share, Share, Share, Share, Share]

VISCOUS_SCALE: Final[Shares6] = (0.9, 0.9, 0.8, 0.9, 0.9, 0.9)
COULOMB_SCALE: Final[Shares6] = (0.8, 0.8, 0.7, 0.8, 0.8, 0.8)
"""Parts of the viscous and dry friction that UR's ``direct_torque`` compensates by
default."""


class DriveTorques(ArmRequest[None], frozen=True):
    """Drive the joints with torques, as URScript's ``direct_torque``.

    The drives add what balances gravity.  A joint that is too fast, or that could not
    stop within its limits any more, is a protective stop.  Servos hide the inertia and
    friction of rotors and gears; in this mode they count.
    """

    is_streamed = True

    torques: Row6
    """Torques of the joints [N·m], shape (6,); none may exceed the joint's limit."""
    viscous_scale: Shares6 = VISCOUS_SCALE
    """Part of each joint's viscous friction that the drives compensate."""
    coulomb_scale: Shares6 = COULOMB_SCALE
    """Part of each joint's dry friction that they compensate."""
    duration: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.02
    """Simulated time until which the next torques must come [s]: without them, the arm
    returns to position control, and ramps to rest."""


class EndTorques(ArmRequest[None], frozen=True):
    """Return from torques to position control, if an arm is driven by them."""


class StartForceMode(ArmRequest[None], frozen=True):
    """Push with a force along some axes of a frame, as URScript's ``force_mode``.

    It is superimposed on what else the arm does; a second request replaces the first.
    The force is the one that the tool exerts on its environment at rest.  Motions and
    their setpoints do not show how far the arm gives way.
    """

    frame: Row6
    """Frame of the task in the base, with a rotation vector [m, rad]."""
    selection: Flags6
    """Axes of the frame that give way: x, y, z, and the rotations about them."""
    wrench: Row6
    """Force and torque along the axes that give way [N, N·m], shape (6,); the numbers
    of other axes do not count."""
    limits: Limits6
    """Largest speed along an axis that gives way [m/s, rad/s]; largest deviation from
    the motion along another that it resists with more force [m, rad]."""
    kind: Literal[1, 2, 3] = 2
    """1: the frame's y axis points from the TCP to the frame's origin.  2: the frame is
    as given.  3: its x axis is the TCP's velocity, projected onto its xy plane."""
    tcp: Row6 = ZERO_POSE
    """The TCP in the flange, with a rotation vector [m, rad]."""
    damping: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.005
    """Damping as of ``force_mode_set_damping``: how soon an undriven motion decays."""
    gain_scaling: Annotated[float, Meta(ge=0.0, le=2.0)] = 1.0
    """Gain scaling as of ``force_mode_set_gain_scaling``: it divides the damping."""
    controller: Name | None = None
    """The active ForceModeController of UR's driver for ROS 2 in whose name the arm
    pushes; without one, the arm must be taken."""


class EndForceMode(ArmRequest[None], frozen=True):
    """End force mode: the arm stops where it is, and a path of it ends."""

    controller: Name | None = None
    """Controller in whose name the arm pushes, as for ``start_force_mode``."""


class StartFreedrive(ArmRequest[None], frozen=True):
    """Start freedrive: the arm is moved by hand, and stays where it is left."""

    axes: Flags6 = (True,) * 6
    """Axes of the frame along which, and about which, the tool gives way."""
    frame: Row6 = ZERO_POSE
    """Frame of the task in the base, with a rotation vector [m, rad]."""
    controller: Name | None = None
    """The active FreedriveModeController of UR's driver for ROS 2 in whose name the arm
    gives way, if it does not so far; without one, the arm must be taken."""


class EndFreedrive(ArmRequest[None], frozen=True):
    """Hold the arm where it is."""

    controller: Name | None = None
    """Controller in whose name the arm gives way, as for ``start_freedrive``."""


class ReadArmMotion(ArmRequest[ArmSample], frozen=True):
    """Setpoint, mode, path and wrench of an arm, as ``state`` messages have them."""


class ZeroWrench(ArmRequest[None], frozen=True):
    """Tare the wrench that states have of an arm."""


class EndStream(Request[None], frozen=True):
    """Ramp down to rest if the arm follows a stream; any other motion goes on.

    The simulation does so itself when a stream has fallen silent.
    """

    arm: Name
