"""PID gains and accelerations that are derived from the model of an arm or gripper.

The rule and its rationale are described in docs/adr/0013-derived-gains.md.  For each
joint of an arm, the rule needs two inertias over all postures.  The smallest inertia is
the inertia of the joint while the other joints are free, without payload.  The largest
inertia is the inertia that the joint has to move, with the rated payload.  The smallest
inertia limits the damping, since the controller samples the velocity.  The damping and
the largest inertia limit the stiffness.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from tool0.description.bodies import (
    STANDARD_GRAVITY,
    BodyInertia,
    JointDynamics,
    Matrix,
    MovingBody,
    moving_bodies,
    total_inertia,
)
from tool0.description.forward_kinematics import link_pose
from tool0.description.model import (
    FLANGE,
    JointLimits,
    JointType,
    RobotModel,
)
from tool0.description.transform import Vector3
from tool0.hardware.sampled_dynamics import SampledDynamics, sample_dynamics

SAMPLING = 1.7
"""Largest eigenvalue of M⁻¹ D · period in any posture.  For an eigenvalue of 2 or more,
damping with sampled velocities is unstable."""
DAMPING_RATIO = 0.1
"""Smallest damping ratio, which occurs at the largest inertia.  The value is low
because the inertia of a pan joint varies by a factor of 100, and a higher damping ratio
would reduce the stiffness."""
BANDWIDTH = 60.0
"""Largest natural frequency at the largest inertia [rad/s].  At the largest frequency,
an oscillation cycle takes about 100 control periods of 1 ms.  A damping ratio above 1
at the largest inertia would only slow the joint."""
INTEGRAL_RATE = 5.0
"""Largest ratio i / p [1/s].  With the largest ratio, a load is compensated within half
a second."""
INTEGRAL_SHARE = 0.6
"""Largest ratio i / p as a fraction of the smallest eigenvalue of D M⁻¹ in any posture,
with payload.  At a fraction of 1 or more, the arm may oscillate."""
LOAD_MARGIN = 1.2
"""Clamp of the integral term relative to the largest static load."""
CLAMP_SHARE = 0.1
"""Smallest clamp of the integral term relative to the joint's effort limit, for joints
that carry no load in the model."""
DRIVE_SHARE = 0.9
"""Fraction of the effort that remains after the static load and may be used for
acceleration."""
LAG = 0.015
"""Error of a joint at its largest acceleration [rad]; oscillation can double the
error."""
ALUMINIUM = 2700.0
"""Density of the payload, which is modeled as a cube around the flange [kg/m³]."""
FULL_EFFORT_ERROR = 0.05
"""Error at which a gripper exerts its full effort, as a fraction of its range."""

_RIGHT_ANGLES = np.arange(4) * (math.pi / 2)
_DIGITS = 3


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DerivedGains:
    """Gains of one joint, and their derivation."""

    p: float
    i: float
    d: float
    i_clamp: float
    derivation: str
    """Derivation of the gains, in one line."""
    acceleration: float = math.inf
    """Largest acceleration of planned motions [rad/s² | m/s²]."""
    jerk: float = math.inf
    """Largest jerk of planned motions [rad/s³ | m/s³]."""
    limits_derivation: str = ""


def derive_arm_gains(
    model: RobotModel,
    joints: Sequence[str],
    payload: float | None,
    *,
    period: float,
    gravity: Vector3 = STANDARD_GRAVITY,
) -> tuple[DerivedGains, ...]:
    """Return the gains of an arm's ``joints``, which form a chain from its base.

    All bodies beyond the arm are treated as fixed to the arm.

    Args:
        model: The robot.
        joints: The joints of the arm.
        payload: The rated payload at the flange [kg], including mounted tools; None if
            the payload is unknown.
        period: Time between controller updates [s].
        gravity: Gravity in the axes of the model's root [m/s²].
    """
    base = model.joint(joints[0]).parent
    rotation = np.array(link_pose(model, {}, base).rotation)
    g_x, g_y, g_z = (rotation.T @ np.asarray(gravity)).tolist()
    is_upright = math.hypot(g_x, g_y) < 0.01 * abs(g_z)
    bodies = moving_bodies(_part(model, base, joints))
    limits = [body.joint.limits for body in bodies]
    postures = _postures(limits, is_upright=is_upright)
    light = _with_rotors(model, bodies, sample_dynamics(bodies, postures))
    loaded = _loaded(model, bodies, payload or 0.0)
    heavy = _with_rotors(
        model, bodies, sample_dynamics(loaded, postures, (g_x, g_y, g_z))
    )
    inverses = np.linalg.inv(light.masses)
    smallest = 1.0 / _diagonals(inverses).max(axis=0)
    largest = _diagonals(heavy.masses).max(axis=0)
    load = np.abs(heavy.loads).max(axis=0)
    shares = np.sqrt(smallest * largest)
    sampled = shares * SAMPLING / _largest_eigenvalue(inverses, shares) / period
    damping = _rounded(np.minimum(sampled, 2.0 * BANDWIDTH * largest))
    frequency = np.minimum(damping / (2.0 * DAMPING_RATIO * largest), BANDWIDTH)
    stiffness = _rounded(largest * frequency**2)
    slowest = 1.0 / _largest_eigenvalue(heavy.masses, 1.0 / damping)
    rate = min(INTEGRAL_SHARE * slowest, INTEGRAL_RATE)
    effort = np.array([limit.effort for limit in limits])
    clamp = np.minimum(
        np.maximum(LOAD_MARGIN * load, CLAMP_SHARE * np.minimum(effort, 1e3)), effort
    )
    usual = np.array([body.joint.max_acceleration for body in bodies])
    by_lag = np.minimum(LAG * stiffness / largest, usual)
    acceleration = _rounded(_within_drives(heavy, effort, by_lag))
    # A ramp over one period of oscillation leaves no residual oscillation.  All joints
    # use the same ramp duration.
    ramp = 2.0 * math.pi / float(frequency.min())
    weight = "without payload (unknown)" if payload is None else f"with {payload:g} kg"
    ratio = damping / (2.0 * np.sqrt(stiffness * largest))
    return tuple(
        DerivedGains(
            p=float(stiffness[k]),
            i=float(_rounded(rate * stiffness[k])),
            d=float(damping[k]),
            i_clamp=float(_rounded(clamp[k])),
            derivation=(
                f"inertia {smallest[k]:.3g} … {largest[k]:.3g} kg·m² {weight}: "
                f"{frequency[k]:.3g} rad/s, damping ratio {ratio[k]:.2g}, "
                f"d·dt/inertia {damping[k] * period / smallest[k]:.2g}, "
                f"load {load[k]:.1f} N·m"
            ),
            acceleration=float(acceleration[k]),
            jerk=float(_rounded(acceleration[k] / ramp)),
            limits_derivation=(
                (
                    "what the drives give the loaded arm in every posture"
                    if acceleration[k] < by_lag[k] * 0.99
                    else f"its error is {LAG * 1e3:g} mrad"
                    if by_lag[k] < usual[k]
                    else "as for any joint"
                )
                + f"; reached in {ramp:.2g} s"
            ),
        )
        for k in range(len(joints))
    )


def derive_gripper_gains(
    model: RobotModel, joint: str, *, period: float
) -> DerivedGains:
    """Return critically damped gains, without an integral, for a gripper's ``joint``.

    The drive of the joint compensates gravity, and the integral term would wind up
    while the gripper holds an object.
    """
    driven = model.joint(joint)
    hand = _part(model, driven.parent)
    names = [item.name for item in hand.movable_joints]
    index = names.index(joint)
    limits = driven.limits
    middle = [0.0] * len(names)
    middle[index] = (limits.lower + limits.upper) / 2.0
    masses = JointDynamics(hand).mass_matrix(middle)
    inertia = float(masses[index, index])
    error = FULL_EFFORT_ERROR * (limits.upper - limits.lower)
    most = (SAMPLING / 4.0 / period) ** 2 * inertia  # bounds d·dt/inertia
    stiffness = float(_rounded(min(limits.effort / error, most)))
    unit, length = (
        ("kg", "m") if driven.type is JointType.PRISMATIC else ("kg·m²", "rad")
    )
    return DerivedGains(
        p=stiffness,
        i=0.0,
        d=float(_rounded(2.0 * math.sqrt(stiffness * inertia))),
        i_clamp=0.0,
        derivation=(
            f"inertia {inertia:.3g} {unit}: critically damped; full effort at an error "
            f"of {limits.effort / stiffness:.2g} {length}"
        ),
    )


def _part(model: RobotModel, root: str, movable: Sequence[str] = ()) -> RobotModel:
    """Return the links of the subtree at ``root`` as a separate model.

    If ``movable`` contains joints, all other joints are fixed at 0.
    """
    links = set(model.links_from(root))
    joints = [
        joint
        if not movable or joint.name in movable
        else replace(joint, type=JointType.FIXED, mimic=None, spring=None)
        for joint in model.joints
        if joint.parent in links
    ]
    names = {joint.name for joint in joints}
    return RobotModel(
        name=model.name,
        root=root,
        links=tuple(link for link in model.links if link.name in links),
        joints=tuple(joints),
        transmissions=tuple(t for t in model.transmissions if t.joint in names),
    )


def _postures(limits: Sequence[JointLimits], *, is_upright: bool) -> Matrix:
    """Return postures with the extreme inertias and loads, shape (n, n_joints) [rad].

    All joints are at multiples of a right angle: the arm is extended or folded, with
    aligned or crossed axes.  The first joint only affects gravity loads, and only if
    the base is not upright.  The last joint has almost no influence.
    """
    first = _RIGHT_ANGLES[: 1 if is_upright else 2]
    between = [_RIGHT_ANGLES] * (len(limits) - 2)
    turned = list(itertools.product(first, *between, (0.0,)))
    lower = [limit.lower for limit in limits]
    upper = [limit.upper for limit in limits]
    return np.clip(np.array(turned), lower, upper)


def _loaded(
    model: RobotModel, bodies: Sequence[MovingBody], payload: float
) -> list[MovingBody]:
    """Return the bodies, plus the payload (minus the mounted mass) at the flange."""
    *inner, last = bodies
    flange = next(
        ((name, at) for name, at in last.links if name.endswith(FLANGE)), None
    )
    name, frame = flange or (last.joint.child, np.eye(4))
    beyond = set(model.links_from(name)) - {name}
    mounted = total_inertia(model, [item for item in last.links if item[0] in beyond])
    mass = max(payload - mounted.mass, 0.0)
    side = (mass / ALUMINIUM) ** (1.0 / 3.0)
    cube = BodyInertia(mass, frame[:3, 3], np.eye(3) * mass * side**2 / 6.0)
    return [*inner, replace(last, inertia=BodyInertia.total([last.inertia, cube]))]


def _with_rotors(
    model: RobotModel, bodies: Sequence[MovingBody], dynamics: SampledDynamics
) -> SampledDynamics:
    drives = [model.transmission_by_joint.get(body.joint.name) for body in bodies]
    rotors = np.diag([drive.armature if drive else 0.0 for drive in drives])
    return dynamics._replace(masses=dynamics.masses + rotors)


def _diagonals(matrices: Matrix) -> Matrix:
    return np.diagonal(matrices, axis1=1, axis2=2)


def _largest_eigenvalue(matrices: Matrix, factors: Matrix) -> float:
    """Return the largest eigenvalue of all ``matrices`` times diag(``factors``).

    The matrices are symmetric.
    """
    root = np.sqrt(factors)
    return float(np.linalg.eigvalsh(root[:, None] * matrices * root).max())


def _within_drives(heavy: SampledDynamics, effort: Matrix, wanted: Matrix) -> Matrix:
    """Return accelerations, up to ``wanted``, that drives can produce in any posture.

    All joints may accelerate at the same time.  The required efforts are combined as
    the root of the sum of squares, as for independent random numbers, since joints that
    accelerate simultaneously do not necessarily act against each other.
    """
    left = np.maximum(DRIVE_SHARE * (effort - np.abs(heavy.loads)), 1e-3 * effort)
    masses = np.abs(heavy.masses)
    accelerations = wanted.copy()
    for _ in range(200):
        shares = masses * accelerations
        needed = np.sqrt((shares**2).sum(axis=2))
        factors = left / needed
        posture, joint = np.unravel_index(factors.argmin(), factors.shape)
        factor = factors[posture, joint]
        if factor >= 1.0 - 1e-6:
            break
        large = shares[posture, joint] >= 0.3 * needed[posture, joint]
        accelerations[large] *= factor
    return accelerations


def _rounded(values: Matrix | float) -> Matrix:
    """Return the values rounded to _DIGITS significant digits."""
    rounded = np.vectorize(lambda value: float(f"{value:.{_DIGITS}g}"))(values)
    return np.asarray(rounded, dtype=np.float64)
