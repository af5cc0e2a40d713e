"""Functions for torque control and dynamics; matrices are lists of rows."""

from __future__ import annotations

from typing import Final

from tool0.protocol.arm_motion import COULOMB_SCALE, VISCOUS_SCALE
from tool0.protocol.state import Six
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Bool, Joints, PoseLike
from tool0.ur.urscript.values import Value
from tool0.ur.urscript_errors import ValueProblem

_NONE: Final = (0.0,) * 6


async def direct_torque(
    thread: Thread,
    torque: Joints,
    viscous_scale: Joints | None = None,
    coulomb_scale: Joints | None = None,
    friction_comp: Bool | None = None,
) -> None:
    """Apply joint torques [N·m] in addition to gravity torques for one control period.

    The scales are the fractions of each joint's friction that are compensated. The
    older friction_comp switches the compensation on or off; it is ignored if a scale is
    specified.
    """
    if friction_comp is False and viscous_scale is None and coulomb_scale is None:
        viscous_scale = coulomb_scale = _NONE
    viscous = _scale("viscous_scale", viscous_scale, VISCOUS_SCALE)
    coulomb = _scale("coulomb_scale", coulomb_scale, COULOMB_SCALE)
    torques = thread.execution.torques
    await thread.moving(lambda: torques.drive(torque, viscous, coulomb))


def _scale(name: str, values: Six | None, default: Six) -> Six:
    if values is None:
        return default
    if not (min(values) >= 0.0 and max(values) <= 1.0):
        raise ValueProblem(f"the numbers of {name} are from 0 to 1")
    return values


def get_mass_matrix(
    thread: Thread, q: Joints | None = None, include_rotors_inertia: Bool = False
) -> Value:
    """Return the mass matrix of the joints, including the payload [kg·m²]."""
    dynamics = thread.box.dynamics
    return dynamics.mass_matrix(q, with_rotors=include_rotors_inertia)


def get_coriolis_and_centrifugal_torques(
    thread: Thread, q: Joints | None = None, qd: Joints | None = None
) -> Value:
    """Return the Coriolis and centrifugal torques, including the payload [N·m]."""
    return thread.box.dynamics.velocity_torques(q, qd)


def get_jacobian(
    thread: Thread, q: Joints | None = None, tcp: PoseLike | None = None
) -> Value:
    """Return the Jacobian of the TCP in the base frame's axes."""
    return thread.box.dynamics.jacobian(q, tcp)


def get_jacobian_time_derivative(
    thread: Thread,
    q: Joints | None = None,
    qd: Joints | None = None,
    tcp: PoseLike | None = None,
) -> Value:
    """Return the time derivative of the TCP's Jacobian in the base frame's axes."""
    return thread.box.dynamics.jacobian_derivative(q, qd, tcp)


def get_actual_joint_accelerations(thread: Thread) -> Value:
    """Return the change of the joint velocities in the last control period [rad/s²]."""
    return thread.box.qdd


FUNCTIONS: Final[tuple[Function, ...]] = (
    function(direct_torque, physical=True),
    function(get_mass_matrix, cost=60),
    function(get_coriolis_and_centrifugal_torques, cost=85),
    function(get_jacobian, cost=4),
    function(get_jacobian_time_derivative, cost=8),
    function(get_actual_joint_accelerations),
)
