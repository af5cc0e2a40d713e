"""Names, bounds and values of the parts of the observed state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from tool0.gym.bounds import (
    FARTHEST,
    FASTEST_OBJECT,
    MOST_TORQUE,
    STRONGEST,
    finite,
)
from tool0.gym.copies import Copies
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

_XYZ: Final = ("x", "y", "z")
_WXYZ: Final = ("qw", "qx", "qy", "qz")
_WRENCH: Final = ("fx", "fy", "fz", "tx", "ty", "tz")
_SPEED: Final = ("vx", "vy", "vz")


class ObservationPart(NamedTuple):
    """One part of the observed state."""

    name: str
    columns: tuple[str, ...]
    """Names of the m numbers in the part."""
    low: Array
    """Lower bounds of the values, shape (m,)."""
    high: Array
    """Upper bounds of the values, shape (m,)."""
    of_robot: bool = True
    """Whether the robot's sensors measure the part; otherwise, it describes the
    surroundings."""


def values(copies: Copies) -> list[Array]:
    """Return the parts of the observed state, each of shape (n, m)."""
    state, task = copies.state, copies.task
    found = []
    for own, arm in zip(copies.arms, state.arms.values(), strict=True):
        found += [
            arm.q,
            arm.qd,
            arm.tcp_position,
            own.space.tool.quats(arm.tcp_rotation),
            arm.opening[:, None],
            arm.opening_target[:, None],
        ]
        if task.needs_wrench:
            found.append(arm.wrench)
    for k in range(len(task.objects)):
        position = state.object_position[:, k]
        found += [
            position,
            state.object_quat[:, k],
            state.object_velocity[:, k],
            *(position - arm.tcp_position for arm in state.arms.values()),
        ]
        if task.objects[k] in copies.resized:
            found.append(state.object_size[:, k])
    achieved, desired = copies.goals()
    found += [desired, desired - achieved]
    for given in task.observe(state).values():
        found.append(finite(np.asarray(given, np.float64).reshape(copies.n, -1)))
    return found


def parts(copies: Copies) -> list[ObservationPart]:
    """Return the descriptions of the parts, in the order of ``values``."""
    found = []
    for arm in copies.arms:
        found += list(_of_arm(arm.space, has_wrench=copies.task.needs_wrench))
    return found + [part._replace(of_robot=False) for part in _around(copies)]


def _of_arm(space: Workspace, *, has_wrench: bool) -> Iterator[ObservationPart]:
    """Yield the parts that the sensors of an arm and its gripper measure."""
    prefix, joints = space.prefix, space.chain.joint_names
    fastest, widest = 2.0 * space.fastest, 1.1 * space.gripper.max_opening
    yield ObservationPart(
        f"{prefix}joint_position",
        tuple(f"{name}.position" for name in joints),
        space.lower - 0.1,
        space.upper + 0.1,
    )
    yield ObservationPart(
        f"{prefix}joint_velocity",
        tuple(f"{name}.velocity" for name in joints),
        -fastest,
        fastest,
    )
    tcp, gripper, wrench = f"{prefix}tcp", f"{prefix}gripper", f"{prefix}wrench"
    yield _symmetric(f"{tcp}_position", _of(tcp, _XYZ), FARTHEST)
    yield _symmetric(f"{tcp}_quat_wxyz", _of(tcp, _WXYZ), 1.0)
    for name in ("opening", "opening_target"):
        columns = _of(gripper, [name])
        yield ObservationPart(
            f"{prefix}{name}", columns, np.zeros(1), np.full(1, widest)
        )
    if has_wrench:
        bound = np.repeat([STRONGEST, MOST_TORQUE], 3)
        yield ObservationPart(wrench, _of(wrench, _WRENCH), -bound, bound)


def _around(copies: Copies) -> Iterator[ObservationPart]:
    """Yield the parts that the robot's sensors do not measure: objects and goal."""
    task = copies.task
    for name in task.objects:
        yield _symmetric(f"{name}_position", _of(name, _XYZ), FARTHEST)
        yield _symmetric(f"{name}_quat_wxyz", _of(name, _WXYZ), 1.0)
        yield _symmetric(f"{name}_velocity", _of(name, _SPEED), FASTEST_OBJECT)
        for arm in copies.arms:
            away = f"{arm.space.prefix}tcp_to_{name}"
            yield _symmetric(away, _of(away, _XYZ), FARTHEST)
        if name in copies.resized:
            zeros, most = np.zeros(3), np.full(3, FARTHEST)
            columns = _of(f"{name}_size", _XYZ)
            yield ObservationPart(f"{name}_size", columns, zeros, most)
    for name in ("goal", "to_goal"):
        yield _symmetric(name, _of(name, task.goal_names), FARTHEST)
    for name, given in task.observe(copies.state).items():
        width = np.reshape(given, (copies.n, -1)).shape[1]
        columns = _of(name, [str(k) for k in range(width)])
        yield _symmetric(name, columns, np.inf)


def _of(name: str, parts: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{name}.{part}" for part in parts)


def _symmetric(name: str, columns: tuple[str, ...], bound: float) -> ObservationPart:
    bounds = np.full(len(columns), bound)
    return ObservationPart(name, columns, -bounds, bounds)
