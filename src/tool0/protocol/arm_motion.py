"""Requests to an arm that is moved by a program instead of ROS controllers.

A program takes the arm, sends paths or streams, and releases it.  Joints are ordered
from base to flange.
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
"""Default longest time between two commands of a stream [wall s]."""


class TakeArm(ArmRequest[None], frozen=True):
    """Take an arm for a program: its controllers are stopped and it holds its position.

    If the arm is already taken, only the program's name changes, and the arm can move
    again after a failed motion or an emergency stop.
    """

    by: Name
    """Name of the program, shown to users."""
    protected: bool = False
    """Whether a failed motion causes a protective stop, as on a UR; otherwise the arm
    stays taken."""


class ReturnArm(ArmRequest[None], frozen=True):
    """Stop an arm and restart its controllers once it is at rest."""

    by: Name | None = None
    """Name of the program that releases the arm.  If another program has taken the arm
    since, nothing happens."""


class ExecutePath(ArmRequest[int], frozen=True):
    """Follow a joint-space path; the response is the path's number, counted from 1.

    The path starts now, at the setpoint, or replaces another path.  Between two knots
    the joints follow cubics, or quintics if accelerations are given.
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
    """Number of the path that this one replaces; if left out, it replaces none."""
    at: PathTime | None = None
    """Time on the replaced path at which this one takes over [s]."""


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
        """Joint accelerations [rad/s²], shape (n, 6); None for cubics."""


def path_request(
    arm: str | None,
    path: SampledPath,
    *,
    after: int | None = None,
    at: float | None = None,
) -> ExecutePath:
    """Return the request that makes a taken arm follow a path.

    ``after`` and ``at`` are passed to ``ExecutePath``.
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
    """Decelerate to rest from any motion."""

    deceleration: Acceleration = 2.0
    """Deceleration of the leading joint [rad/s²].  With ``along_path``, deceleration of
    the path's speed [1/s²]; at 2, the arm stops within half a second."""
    along_path: bool = False
    """Whether an arm that follows a path stays on the path while it stops."""


class ServoJoints(ArmRequest[None], frozen=True):
    """Follow a target, usually one of a stream of targets, like URScript's ``servoj``.

    Each request that is sent without an id is executed at the next tick.  The control
    law is qdd = gain (target - (q + lookahead_time qd)), where q and qd are the
    setpoint's; joint limits apply.  The speed slider scales the largest velocity.
    """

    is_streamed = True

    positions: Row6
    """Joint positions to move to [rad], shape (6,)."""
    duration: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.002
    """Simulated time until the next target is expected [s]; after it, the arm holds the
    last target."""
    lookahead_time: Annotated[float, Meta(ge=0.03, le=0.2)] = 0.1
    """Lookahead time of the control law [s]; a longer one is smoother but lags more."""
    gain: Annotated[float, Meta(ge=100.0, le=2000.0)] = 300.0
    """Gain of the control law [1/s²]."""
    timeout: Timeout = SILENCE
    """Longest wall time between two targets of a stream [s].  If the next target is
    later, the stream has ended: the arm stops, and ignores further targets until it is
    stopped (``stop_arm``), follows a path or is taken again."""


class SpeedJoints(ArmRequest[None], frozen=True):
    """Accelerate to joint velocities, like URScript's ``speedj``.

    The speed slider scales the velocities.
    """

    is_streamed = True

    velocities: Row6
    """Joint velocities [rad/s], shape (6,)."""
    acceleration: Acceleration = 1.4
    """Acceleration of the leading joint [rad/s²]."""
    duration: Duration | None = None
    """Time after which the arm decelerates to rest [s]; if left out or 0, it keeps
    moving."""
    timeout: Timeout | None = None
    """Longest wall time between two targets of a stream [s], see ``servo_joints``.  If
    left out, 0.5 s without a ``duration``, and unlimited with one."""


class SpeedTool(ArmRequest[None], frozen=True):
    """Accelerate to a velocity of the tool, like URScript's ``speedl``.

    Where a joint would be too fast or reach its limit, the tool slows down but keeps
    its direction.
    """

    is_streamed = True

    twist: Row6
    """Linear and angular velocity of the TCP, in the base's axes [m/s, rad/s]."""
    acceleration: Acceleration = 1.2
    """Linear acceleration of the tool [m/s²]; the same number limits its angular
    acceleration [rad/s²]."""
    duration: Duration | None = None
    """Time after which the arm decelerates to rest [s]; if left out or 0, it keeps
    moving."""
    timeout: Timeout | None = None
    """Longest wall time between two targets of a stream [s], see ``servo_joints``.  If
    left out, 0.5 s without a ``duration``, and unlimited with one."""
    tcp: Row6 = ZERO_POSE
    """Pose of the TCP in the flange's frame: position and rotation vector [m, rad]."""


Share = Annotated[float, Meta(ge=0.0, le=1.0)]

Shares6 = tuple[Share, Share, Share, Share, Share, Share]

VISCOUS_SCALE: Final[Shares6] = (0.9, 0.9, 0.8, 0.9, 0.9, 0.9)
COULOMB_SCALE: Final[Shares6] = (0.8, 0.8, 0.7, 0.8, 0.8, 0.8)
"""Fractions of the viscous and dry friction that UR's ``direct_torque`` compensates by
default."""


class DriveTorques(ArmRequest[None], frozen=True):
    """Drive the joints with torques, like URScript's ``direct_torque``.

    The drives compensate gravity in addition.  A joint that is too fast, or that could
    no longer stop within its limits, triggers a protective stop.  In this mode, unlike
    in position control, the inertia and friction of rotors and gears affect the motion.
    """

    is_streamed = True

    torques: Row6
    """Torques of the joints [N·m], shape (6,); none may exceed the joint's limit."""
    viscous_scale: Shares6 = VISCOUS_SCALE
    """Fraction of each joint's viscous friction that the drives compensate."""
    coulomb_scale: Shares6 = COULOMB_SCALE
    """Fraction of each joint's dry friction that the drives compensate."""
    duration: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.02
    """Simulated time within which the next torques must arrive [s]; otherwise, the arm
    returns to position control and decelerates to rest."""


class EndTorques(ArmRequest[None], frozen=True):
    """Return an arm that is driven by torques to position control."""


class StartForceMode(ArmRequest[None], frozen=True):
    """Push with a force along some axes of a frame, like URScript's ``force_mode``.

    Force mode is superimposed on the arm's motion; a second request replaces the first.
    The wrench is the one that the tool exerts on its environment at rest.  Motions and
    their setpoints do not include the compliant deviation.
    """

    frame: Row6
    """Pose of the task frame in the base: position and rotation vector [m, rad]."""
    selection: Flags6
    """Compliant axes of the frame: x, y, z, and the rotations about them."""
    wrench: Row6
    """Force and torque along the compliant axes [N, N·m], shape (6,); the numbers for
    other axes are ignored."""
    limits: Limits6
    """For compliant axes, the largest speed [m/s, rad/s]; for other axes, the largest
    deviation from the motion [m, rad], up to which the restoring force grows."""
    kind: Literal[1, 2, 3] = 2
    """1: the frame's y axis points from the TCP to the frame's origin. 2: the frame is
    as given. 3: the frame's x axis is the TCP's velocity projected onto its xy
    plane."""
    tcp: Row6 = ZERO_POSE
    """Pose of the TCP in the flange's frame: position and rotation vector [m, rad]."""
    damping: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.005
    """Damping as in URScript's ``force_mode_set_damping``: how fast a motion decays
    when no force drives it."""
    gain_scaling: Annotated[float, Meta(ge=0.0, le=2.0)] = 1.0
    """Gain scaling as in URScript's ``force_mode_set_gain_scaling``; the damping is
    divided by it."""
    controller: Name | None = None
    """Active ForceModeController (of UR's driver for ROS 2) on whose behalf the arm
    pushes; if left out, the arm must be taken."""


class EndForceMode(ArmRequest[None], frozen=True):
    """End force mode: the arm stops where it is, and its path ends."""

    controller: Name | None = None
    """Controller on whose behalf the arm pushes; see ``start_force_mode``."""


class StartFreedrive(ArmRequest[None], frozen=True):
    """Start freedrive: the arm can be moved by hand and stays where it is left."""

    axes: Flags6 = (True,) * 6
    """Axes of the frame along and about which the tool can be moved."""
    frame: Row6 = ZERO_POSE
    """Pose of the task frame in the base: position and rotation vector [m, rad]."""
    controller: Name | None = None
    """Active FreedriveModeController (of UR's driver for ROS 2) on whose behalf the arm
    enters freedrive, unless it already has; if left out, the arm must be taken."""


class EndFreedrive(ArmRequest[None], frozen=True):
    """End freedrive: the arm holds its position."""

    controller: Name | None = None
    """Controller on whose behalf the arm is in freedrive; see ``start_freedrive``."""


class ReadArmMotion(ArmRequest[ArmSample], frozen=True):
    """Read an arm's setpoint, mode, path and wrench, as in ``state`` messages."""


class ZeroWrench(ArmRequest[None], frozen=True):
    """Tare the arm's wrench, which states contain."""


class EndStream(Request[None], frozen=True):
    """Decelerate the arm to rest if it follows a stream; other motions continue.

    The simulation does this by itself when a stream stops sending.
    """

    arm: Name
