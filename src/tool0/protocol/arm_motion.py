"""Requests to an arm that a program, rather than a ROS controller, moves.

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
"""One number for each joint, from base to flange."""

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
"""Default maximum time between two commands of a stream [wall s]."""


class TakeArm(ArmRequest[None], frozen=True):
    """Take an arm for a program: stop its controllers, and hold its position.

    If the arm is already taken, only the name of the program changes.  The arm can also
    move again after a failed motion or an emergency stop.
    """

    by: Name
    """Name of the program, which is shown to users."""
    protected: bool = False
    """Whether a failed motion causes a protective stop, as on a UR; otherwise, the arm
    remains taken."""


class ReturnArm(ArmRequest[None], frozen=True):
    """Stop an arm, and restart its controllers once it is at rest."""

    by: Name | None = None
    """Name of the program that releases the arm.  If another program has taken the arm
    in the meantime, the request has no effect."""


class ExecutePath(ArmRequest[int], frozen=True):
    """Follow a joint-space path; the response is the path number, counted from 1.

    The path starts immediately at the present setpoint, or it replaces another path.
    Between two knots, the joints follow cubic polynomials, or quintic polynomials if
    accelerations are given.
    """

    unchecked = ("times", "positions", "velocities", "accelerations")

    times: Annotated[tuple[float, ...], Meta(min_length=1, max_length=MOST_KNOTS)]
    """Times of the knots after the start [s], increasing.  A knot at 0 must be equal to
    the setpoint, within 1e-6 rad and 1e-6 rad/s."""
    positions: Annotated[Rows6, Meta(max_length=MOST_KNOTS)]
    """Joint positions at the knots [rad], shape (n, 6)."""
    velocities: Annotated[Rows6, Meta(max_length=MOST_KNOTS)]
    """Joint velocities at the knots [rad/s], shape (n, 6); 0 at the last knot."""
    accelerations: Annotated[Rows6, Meta(max_length=MOST_KNOTS)] = ()
    """Joint accelerations at the knots [rad/s²], shape (n, 6), or empty."""
    after: PathNumber | None = None
    """Number of the path that this path replaces; by default, no path is replaced."""
    at: PathTime | None = None
    """Time on the replaced path at which this path begins [s]."""


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
        """Joint accelerations [rad/s²], shape (n, 6); None for cubic polynomials."""


def path_request(
    arm: str | None,
    path: SampledPath,
    *,
    after: int | None = None,
    at: float | None = None,
) -> ExecutePath:
    """Return the request to follow a path with a taken arm.

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
    """Deceleration of the leading joint [rad/s²].  With ``along_path``, this is the
    deceleration of the path's speed [1/s]; at 2, the arm stops within half a
    second."""
    along_path: bool = False
    """Whether an arm that follows a path stays on it during the deceleration."""


class ServoJoints(ArmRequest[None], frozen=True):
    """Follow a target or a stream of targets, as URScript's ``servoj`` does.

    Each request that is sent without an id is executed at the next tick.  The control
    law is qdd = gain (target - (q + lookahead_time qd)), where q and qd are the
    position and the velocity of the setpoint.  Joint limits apply.  The speed slider
    scales the maximum velocity.
    """

    is_streamed = True

    positions: Row6
    """Target positions of the joints [rad], shape (6,)."""
    duration: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.002
    """Simulated time until the next target is expected [s].  After this time, the arm
    holds the last target."""
    lookahead_time: Annotated[float, Meta(ge=0.03, le=0.2)] = 0.1
    """Lookahead time of the control law [s].  A longer time makes the motion smoother,
    but increases its lag."""
    gain: Annotated[float, Meta(ge=100.0, le=2000.0)] = 300.0
    """Gain of the control law [1/s²]."""
    timeout: Timeout = SILENCE
    """Longest wall time between two targets of a stream [s].  If no target is received
    within this time, the stream has ended: the arm stops, and ignores further targets
    until it is stopped (``stop_arm``), follows a path or is taken again."""


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
    """Time after which the arm decelerates to rest [s]; with the default
    or 0, the arm continues to move."""
    timeout: Timeout | None = None
    """Longest wall time between two targets of a stream [s]; see ``servo_joints``.  The
    default is 0.5 s without a ``duration``; with a ``duration``, the time is
    unlimited."""


class SpeedTool(ArmRequest[None], frozen=True):
    """Accelerate the tool to a velocity, as URScript's ``speedl`` does.

    If a joint would be too fast or would reach its limit, the tool decelerates, but
    keeps its direction of motion.
    """

    is_streamed = True

    twist: Row6
    """Linear and angular velocity of the TCP, in the axes of the base [m/s, rad/s]."""
    acceleration: Acceleration = 1.2
    """Linear acceleration of the tool [m/s²].  The same number limits the angular
    acceleration of the tool [rad/s²]."""
    duration: Duration | None = None
    """Time after which the arm decelerates to rest [s]; with the default
    or 0, the arm continues to move."""
    timeout: Timeout | None = None
    """Longest wall time between two targets of a stream [s]; see ``servo_joints``.  The
    default is 0.5 s without a ``duration``; with a ``duration``, the time is
    unlimited."""
    tcp: Row6 = ZERO_POSE
    """Pose of the TCP in the flange frame: position and rotation vector [m, rad]."""


Share = Annotated[float, Meta(ge=0.0, le=1.0)]

Shares6 = tuple[Share, Share, Share, Share, Share, Share]

VISCOUS_SCALE: Final[Shares6] = (0.9, 0.9, 0.8, 0.9, 0.9, 0.9)
COULOMB_SCALE: Final[Shares6] = (0.8, 0.8, 0.7, 0.8, 0.8, 0.8)
"""Default fractions of the viscous and dry friction that URScript's ``direct_torque``
compensates."""


class DriveTorques(ArmRequest[None], frozen=True):
    """Apply torques to the joints, like URScript's ``direct_torque``.

    In addition, the drives compensate gravity.  A joint triggers a protective stop if
    it is too fast, or if it could no longer stop within its limits.  In this mode,
    unlike in position control, the inertia and the friction of rotors and gears affect
    the motion.
    """

    is_streamed = True

    torques: Row6
    """Torques of the joints [N·m], shape (6,).  Each torque must be within the limit of
    the joint."""
    viscous_scale: Shares6 = VISCOUS_SCALE
    """Fraction of each joint's viscous friction that the drives compensate."""
    coulomb_scale: Shares6 = COULOMB_SCALE
    """Fraction of each joint's dry friction that the drives compensate."""
    duration: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.02
    """Simulated time within which the next torques must be received [s].  Otherwise,
    the arm returns to position control and decelerates to rest."""


class EndTorques(ArmRequest[None], frozen=True):
    """Switch an arm from torque control back to position control."""


class StartForceMode(ArmRequest[None], frozen=True):
    """Apply a force along some axes of a frame, as URScript's ``force_mode`` does.

    Force mode is superimposed on the arm's motion; a second request replaces the first
    request.  ``wrench`` is the wrench that the tool, when at rest, exerts on its
    environment.  Motions and setpoints do not include the compliant deviation.
    """

    frame: Row6
    """Pose of the task frame in the base: position and rotation vector [m, rad]."""
    selection: Flags6
    """Compliant axes of the frame: x, y, z, and the rotations about x, y, z."""
    wrench: Row6
    """Force and torque along the compliant axes [N, N·m], shape (6,); the values for
    the other axes are ignored."""
    limits: Limits6
    """For compliant axes, the maximum speed [m/s, rad/s].  For the other axes, the
    deviation from the motion [m, rad] at which the restoring force stops increasing."""
    kind: Literal[1, 2, 3] = 2
    """1: the frame's y axis points from the TCP to the frame's origin. 2: the frame is
    used as given. 3: the frame's x axis is the velocity of the TCP, projected onto the
    frame's xy plane."""
    tcp: Row6 = ZERO_POSE
    """Pose of the TCP in the flange frame: position and rotation vector [m, rad]."""
    damping: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.005
    """Damping, as in URScript's ``force_mode_set_damping``: the rate at which a motion
    decays without a driving force."""
    gain_scaling: Annotated[float, Meta(ge=0.0, le=2.0)] = 1.0
    """Gain scaling, as in URScript's ``force_mode_set_gain_scaling``.  The damping is
    divided by this value."""
    controller: Name | None = None
    """Active ForceModeController (from UR's driver for ROS 2) that requests force mode.
    Without a controller, the arm must be taken."""


class EndForceMode(ArmRequest[None], frozen=True):
    """End force mode: the arm stops at its present position, and its path ends."""

    controller: Name | None = None
    """Controller that requested force mode; see ``start_force_mode``."""


class StartFreedrive(ArmRequest[None], frozen=True):
    """Start freedrive: the arm can be guided by hand, and stays where it is left."""

    axes: Flags6 = (True,) * 6
    """Axes of the frame along or about which the tool can be moved."""
    frame: Row6 = ZERO_POSE
    """Pose of the task frame in the base: position and rotation vector [m, rad]."""
    controller: Name | None = None
    """Active FreedriveModeController (from UR's driver for ROS 2) that requests
    freedrive.  If the controller has already started freedrive, the request has no
    effect.  Without a controller, the arm must be taken."""


class EndFreedrive(ArmRequest[None], frozen=True):
    """End freedrive: the arm holds its position."""

    controller: Name | None = None
    """Controller that requested freedrive; see ``start_freedrive``."""


class ReadArmMotion(ArmRequest[ArmSample], frozen=True):
    """Read the arm's setpoint, mode, path and wrench, as in ``state`` messages."""


class ZeroWrench(ArmRequest[None], frozen=True):
    """Tare the arm's wrench in ``state`` messages."""


class EndStream(Request[None], frozen=True):
    """Decelerate the arm to rest if it is following a stream; other motions continue.

    The simulation ends a stream automatically when it contains no further targets.
    """

    arm: Name
