"""Force mode and freedrive: joint efforts that make an arm compliant along some axes.

The efforts balance gravity.  Along the compliant axes of a frame, the tool exerts a
commanded force, and its motion is damped.  Along the stiff axes, virtual springs and
dampers, scaled by the inertia, make the tool follow its nominal motion.

The springs, the commanded force and the damping are combined into one wrench on the
tool.  At rest, therefore, only the commanded force acts along the compliant axes.  The
force on the environment equals the commanded force, regardless of the environment's
stiffness and of the friction along the stiff axes.  No force measurement is needed.  If
the full mass matrix were used to convert accelerations to efforts, its off-diagonal
terms would also cause forces along the compliant axes.  Therefore, a wrench that
accelerates the tool along only some axes is computed from the block of J M⁻¹ Jᵀ for
these axes.  The matrix J M⁻¹ Jᵀ is the inverse of the task-space inertia (Khatib 1987,
https://doi.org/10.1109/JRA.1987.1087068).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, NamedTuple, final

import numpy as np

from tool0.control.arm.model import ArmModel, Placement
from tool0.control.arm.stream import SINGULAR, damped_inverse
from tool0.hardware.engine import JointSelector, JointState
from tool0.protocol.state import ArmSetpoint

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Mask = NDArray[np.bool_]

BANDWIDTH: Final = 60.0
"""Natural frequency of the virtual springs [rad/s].  If the physics step is too long, a
lower frequency is used."""
LARGEST_STEP: Final = 0.2
"""Largest product of the physics step [s] and a natural frequency or decay rate [1/s]
at which the springs remain stable."""
DAMPING_RANGE: Final = (10.0, 200.0)
"""Decay rates of undriven motion for damping parameters of 0 and 1 [1/s]."""
FREEDRIVE_DAMPING: Final = 8.0
"""Damping in freedrive [1/s]."""
JOINT_DAMPING: Final = 1.0
"""Damping rate of the joints' deviation from the nominal motion [1/s].  This damping is
needed in singular postures."""
RIDGE: Final = SINGULAR**2
"""Fraction by which the mobility along each axis is increased in a singular posture, so
that the spring forces remain finite."""
EASE: Final = 0.3
"""The force is faded out over this fraction of a speed limit, just below the limit."""
SLOWEST: Final = 1e-9
"""Lower bound of the speed limits in the computation of the fade-out [m/s, rad/s]."""
UNLIMITED: Final = 100.0
"""Finite value that replaces infinite speed and deviation limits [m/s, rad/s, m,
rad]."""
SLOW: Final = 1e-3
"""Speed of the TCP below which its direction of motion is considered undefined
[m/s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ComplianceTask:
    """Compliant axes and the wrench along them: the arguments of ``force_mode``."""

    frame: Array
    """Pose of the task frame in the base frame, a homogeneous matrix of shape (4,
    4)."""
    free: Mask
    """Whether each axis is compliant, as booleans of shape (6,): translation along x, y
    and z, and rotation about x, y and z."""
    wrench: Array
    """Wrench on the environment along the compliant axes [N, N·m], shape (6,)."""
    kind: int = 2
    """Type of the task frame.  1: the y axis points from the TCP to the frame's origin.
    2: the frame is fixed.  3: the x axis points in the direction of the TCP's velocity,
    projected onto the frame's xy plane."""
    limits: Array
    """Limit for each axis, shape (6,): the largest speed along a compliant axis [m/s,
    rad/s], or the deviation along a stiff axis beyond which the spring force no longer
    increases [m, rad]."""
    lever: Array
    """Position of the TCP in the flange frame [m], shape (3,)."""
    damping: float
    """Decay rate of undriven motion [1/s]."""
    is_freedrive: bool = False

    def stiffened(self) -> ComplianceTask:
        """Return a copy of the task that has no compliant axes."""
        none, most = np.zeros(6, dtype=bool), np.full(6, UNLIMITED)
        return replace(self, free=none, limits=most, is_freedrive=False)

    def axes(self, position: Array, velocity: Array) -> Array:
        """Return the axes in which the wrench is expressed, as columns, shape (3, 3).

        ``position`` and ``velocity`` are the TCP's position and velocity in the base
        frame.
        """
        R = self.frame[:3, :3]
        z = R[:, 2]
        if self.kind == 1:
            y = _unit(self.frame[:3, 3] - position)
            x = _unit(np.cross(y, z)) if y is not None else None
            return R if x is None or y is None else np.stack([x, y, np.cross(x, y)], 1)
        if self.kind == 3:
            x = _unit(velocity - z * (z @ velocity), SLOW)
            return R if x is None else np.stack([x, np.cross(z, x), z], 1)
        return R


def force_damping(damping: float, gain_scaling: float) -> float:
    """Return the decay rate [1/s] for the parameters of ``force_mode``."""
    least, most = DAMPING_RANGE
    rate = least + damping * (most - least)
    return rate / gain_scaling if gain_scaling else math.inf


def _unit(vector: Array, least: float = 1e-6) -> Array | None:
    size = float(np.linalg.norm(vector))
    return vector / size if size > least else None


class _Inertias(NamedTuple):
    """Matrices that map motion along a task's axes to wrenches, of shape (6, 6)."""

    held: Array
    """Wrench per acceleration along the stiff axes.  The wrench has components along
    the stiff axes only."""
    free: Array
    """Wrench per acceleration along the compliant axes.  Within a single step, the
    stiff axes are treated as free, since only springs hold them."""
    drag: Array
    """Wrench per velocity along the compliant axes, computed from the inertia along
    these axes while the stiff axes are held.  This inertia can be much larger than the
    inertia while the stiff axes are free.  This difference limits the decay rate."""


@final
class Compliance:
    """Converts a nominal motion to joint efforts for a compliance task."""

    def __init__(
        self, model: ArmModel, task: ComplianceTask, select: JointSelector
    ) -> None:
        """Store the task; ``select`` extracts the arm's values from a state."""
        self.task = task
        self._model = model
        self._select = select
        self._nominal: tuple[float, ArmSetpoint] | None = None
        """Time of the last nominal motion [s], and the motion itself."""
        self._known: tuple[Sequence[float], Placement] | None = None
        """The last nominal joint positions, and the corresponding pose of the TCP."""
        self._weighed: tuple[Array, Array, _Inertias] | None = None
        """The mass matrix and axes of the last computation, and the resulting
        inertias."""

    def follow(self, nominal: ArmSetpoint, time: float) -> None:
        """Follow a nominal motion with constant accelerations from ``time`` [s]."""
        self._nominal = time, nominal

    def efforts(self, state: JointState, dt: float) -> list[float]:
        """Return the joint efforts for the next step of ``dt`` seconds [N·m]."""
        task = self.task
        position = np.asarray(self._select(state.position))
        speed = np.asarray(self._select(state.velocity))
        nominal = self._nominal_at(state.time)
        masses, weight = self._model.dynamics(state)
        here = self._model.place(position, task.lever)
        J = here.jacobian
        twist = J @ speed
        goal = self._placed(nominal)
        nominal_twist = goal.jacobian @ np.asarray(nominal.velocities)
        R = task.axes(here.position, nominal_twist[:3])
        axes = np.zeros((6, 6))
        axes[:3, :3] = axes[3:, 3:] = R.T
        error = axes @ _pose_error(here, goal)
        error = np.clip(error, -task.limits, task.limits)
        velocity = axes @ twist
        slip = axes @ nominal_twist - velocity
        rate = min(BANDWIDTH, LARGEST_STEP / dt)
        springs = rate * (rate * error + 2.0 * slip)
        along = axes @ J
        inertias = self._inertias(masses, along, R, dt)
        excess = np.clip(np.abs(velocity) - task.limits, 0.0, None) * np.sign(velocity)
        wrench = (
            inertias.held @ springs
            + self._share(velocity) * np.where(task.free, task.wrench, 0.0)
            - inertias.drag @ velocity
            - LARGEST_STEP / dt * (inertias.free @ excess)
        )
        wanted = JOINT_DAMPING * (np.asarray(nominal.velocities) - speed)
        if any(nominal.accelerations):
            ahead = axes @ (goal.jacobian @ np.asarray(nominal.accelerations))
            wanted += damped_inverse(J, axes.T @ np.where(task.free, 0.0, ahead))
        efforts = weight + masses @ wanted + along.T @ wrench
        found: list[float] = efforts.tolist()
        return found

    def _share(self, velocity: Array) -> Array:
        """Return the fraction of the wrench that acts along each axis, shape (6,).

        The wrench along an axis is faded out as the speed in the direction of the
        wrench approaches its limit.
        """
        task = self.task
        left = task.limits - velocity * np.sign(task.wrench)
        return np.clip(left / np.maximum(EASE * task.limits, SLOWEST), 0.0, 1.0)

    def _inertias(self, masses: Array, along: Array, R: Array, dt: float) -> _Inertias:
        """Return the inertias for the mass matrix ``masses`` and the axes ``R``.

        ``along`` is the tool's Jacobian, expressed in the axes ``R``.  The inertias are
        reused as long as the mass matrix and the axes are unchanged.  Near singular
        postures, where the inertias change quickly, they are always recomputed.
        """
        known = self._weighed
        if known is not None and known[0] is masses and np.array_equal(known[1], R):
            return known[2]
        task = self.task
        mobility = along @ np.linalg.solve(masses, along.T)
        singularity = _singularity(along)
        mobility += RIDGE * singularity * np.diag(np.diag(mobility))
        free = _inertia(mobility, task.free)
        whole = np.where(np.outer(task.free, task.free), np.linalg.inv(mobility), 0.0)
        ratio = np.trace(mobility @ whole) - task.free.sum() + 1.0
        drag = min(task.damping, LARGEST_STEP / dt / ratio) * whole
        found = _Inertias(_inertia(mobility, ~task.free), free, drag)
        self._weighed = (masses, R, found) if singularity == 0.0 else None
        return found

    def _nominal_at(self, time: float) -> ArmSetpoint:
        assert self._nominal is not None  # set in the tick
        since, nominal = self._nominal
        t = time - since
        if nominal.is_at_rest or t == 0.0:
            return nominal
        return ArmSetpoint(
            tuple(q + t * (v + 0.5 * t * a) for q, v, a in zip(*nominal, strict=True)),
            tuple(
                v + t * a
                for v, a in zip(nominal.velocities, nominal.accelerations, strict=True)
            ),
            nominal.accelerations,
        )

    def _placed(self, nominal: ArmSetpoint) -> Placement:
        """Return the nominal pose of the TCP.

        The pose is cached, since the nominal joint positions rarely change.
        """
        known = self._known
        if known is None or known[0] != nominal.positions:
            place = self._model.place(np.asarray(nominal.positions), self.task.lever)
            self._known = known = nominal.positions, place
        return known[1]


def _inertia(mobility: Array, along: Mask) -> Array:
    """Return the inertia (wrench per acceleration) along some axes, shape (6, 6).

    ``mobility`` is the inverse of the inertia (acceleration per wrench) along all axes,
    shape (6, 6).
    """
    found = np.zeros((6, 6))
    found[np.ix_(along, along)] = np.linalg.inv(mobility[along][:, along])
    return found


def _singularity(J: Array) -> float:
    """Return the degree of singularity, from 0 (regular posture) to 1 (singular)."""
    smallest = float(np.linalg.svd(J, compute_uv=False)[-1])
    return 1.0 - min(1.0, smallest / SINGULAR) ** 2


def _pose_error(here: Placement, goal: Placement) -> Array:
    """Return the pose error from ``here`` to ``goal`` [m, rad], shape (6,).

    The error is expressed in base axes.  The rotational part is the rotation axis times
    the sine of the rotation angle.  For small angles, this sine is close to the angle
    itself.
    """
    R = goal.rotation @ here.rotation.T
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.concatenate([goal.position - here.position, turn])
