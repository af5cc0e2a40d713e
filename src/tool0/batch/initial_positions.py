"""Joint positions at which ``Batch.reset`` places copies."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from tool0.batch.arguments import Arguments, Indices
from tool0.description.model import Joint, RobotModel
from tool0.errors import LimitsError
from tool0.kinematics.chain import Array


def initial_positions(
    model: RobotModel,
    joint_names: Sequence[str],
    position: ArrayLike,
    rows: Indices,
    check: Arguments,
) -> dict[str, Array]:
    """Return the positions [rad | m] of each joint that is not a mimic joint.

    Each array has one position per row.

    Args:
        model: The robot.
        joint_names: The joints, in the order of ``position``.
        position: Positions of all joints of n copies, shape (n, n_joints).
        rows: Numbers of the copies to reset.
        check: Checks of the arguments of the method.

    Raises:
        ControlError: If the shape or a number of ``position`` is wrong.
        LimitsError: If a position is outside the limits of a joint.
    """
    free = [joint for joint in model.movable_joints if joint.mimic is None]
    axes = f" for joints {', '.join(joint_names)}"
    q = check.rows("position", position, (len(joint_names),), rows, axes)
    columns = [joint_names.index(joint.name) for joint in free]
    _check_limits(free, q[:, columns], rows)
    names = [joint.name for joint in free]
    return dict(zip(names, q[rows][:, columns].T, strict=True))


def _check_limits(joints: Sequence[Joint], positions: Array, rows: Indices) -> None:
    """Raise LimitsError for positions (n, k) outside the joints' limits."""
    for k, joint in enumerate(joints):
        limits = joint.limits
        for i in rows.tolist():
            if not limits.lower <= positions[i, k] <= limits.upper:
                raise LimitsError(
                    f"Batch.reset: position {positions[i, k]} of joint '{joint.name}' "
                    f"in copy {i} is outside [{limits.lower}, {limits.upper}]"
                )
