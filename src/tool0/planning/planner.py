"""Planner of collision-free motions: straight line or search, shortcuts and timing."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from tool0.description.model import Joint, JointType
from tool0.errors import CollisionError, PlanningError
from tool0.kernel.clearance import FREE, Cancelled, Ended
from tool0.kinematics.chain import Array
from tool0.motion.path import Path
from tool0.motion.waypoints import SmoothWay, time_way
from tool0.planning.world import PlanningGroup

LONGEST: Final = 0.5
"""Maximum step by which a search tree is extended [rad]."""
MOST_NODES: Final = 20_000
"""Maximum number of nodes in a search tree."""
RESTARTS: Final = 3
"""Number of searches. The planner uses the fastest path of all searches."""
MOST_GOALS: Final = 24
BESIDE: Final = 2.0
"""Most samples lie within this distance of the region between the start and a goal
[rad]."""
ENOUGH: Final = 4_000
"""Number of checked poses after which the search ends if a path has been found."""
_TRIES: Final = 60
"""Number of random shortcuts that the planner tries."""
_CUT: Final = 0.2
"""Initial distance from a corner at which the motion starts to cut it [rad]."""
_STOP: Final = 0.002
"""Distance below which the motion stops at the corner instead of cutting it [rad]."""
_CHORDS: Final = 16
_TURN: Final = 2.0 * math.pi
_SAME: Final = 1e-9


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeMotion:
    """A motion that maintains its clearance, and statistics of the search for it."""

    path: Path
    waypoints: Array
    """Joint positions at the corners of the path [rad | m], shape (n, n_joints)."""
    is_direct: bool
    """Whether the motion is a straight line in joint space."""
    samples: int
    """Number of random poses that the search sampled."""
    poses: int
    """Number of poses at which distances were measured."""
    planning_time: float
    """Wall time of the planning [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """Options of the search."""

    speed: float = 0.5
    """Speed as a fraction of the joints' maximum velocities."""
    timeout: float = 5.0
    """Maximum wall time of the search [s]."""
    seed: int = 0
    restarts: int = RESTARTS


def plan_free_motion(
    group: PlanningGroup,
    joints: Sequence[Joint],
    start: Array,
    goals: Array,
    *,
    options: SearchOptions,
    cancelled: Cancelled,
) -> FreeMotion:
    """Return the fastest collision-free motion to any goal that the planner finds.

    Args:
        group: Collision checks for the joints of the motion.
        joints: The joints that move, with their limits.
        start: Start positions of the joints [rad | m], shape (n_joints,).
        goals: Target positions within the limits, shape (n, n_joints), n >= 1.
        options: Options of the search.
        cancelled: Flag that another thread can set to cancel the search.

    Raises:
        CollisionError: If the start or every goal is in collision; the message lists
            the bodies.
        PlanningError: If no path is found within the timeout.
    """
    begun = time.perf_counter()
    looked = group.clearances.poses
    group.begin(start)
    fastest = np.array([joint.max_velocity for joint in joints])
    numbers = _free_goals(group, start, goals, fastest)
    way, samples, is_direct = _direct(group, start, goals, numbers), 0, True
    if way is None:
        way, samples = _searched(
            group,
            joints,
            (start, goals[numbers]),
            options=options,
            cancelled=cancelled,
            begun=begun,
        )
        is_direct = False
    path = _timed(group, joints, way, options.speed)
    return FreeMotion(
        path=path,
        waypoints=way,
        is_direct=is_direct,
        samples=samples,
        poses=group.clearances.poses - looked,
        planning_time=time.perf_counter() - begun,
    )


def check_way(group: PlanningGroup, poses: Array) -> tuple[int, float, str] | None:
    """Return where and why the motion along straight lines between poses is not free.

    The result contains the row of the pose before the collision, the fraction of the
    segment up to the collision, and the reason. The result is None if the whole motion
    is free. Bodies that overlap at the start may overlap by the same depth later.
    """
    group.begin(poses[0], is_check=True)
    found = group.clearances.along(poses)
    if found is None:
        return None
    row = min(found.row, len(poses) - 2)
    part = found.part if row == found.row else 1.0
    q = poses[row] + part * (poses[row + 1] - poses[row])
    return row, part, group.explained(found.pair, q)


def windings(q: Array, joints: Sequence[Joint], start: Array) -> Array:
    """Return all postures within limits that differ from ``q`` by whole turns, (n, m).

    Positions that are more than one turn away from the start are omitted.
    """
    choices = []
    for value, joint, here in zip(q.tolist(), joints, start.tolist(), strict=True):
        lower, upper = _limits(joint, here)
        if joint.type is JointType.PRISMATIC:
            choices.append([value])
            continue
        first = math.ceil((max(lower, here - _TURN) - value - _SAME) / _TURN)
        last = math.floor((min(upper, here + _TURN) - value + _SAME) / _TURN)
        turned = [value + k * _TURN for k in range(first, last + 1)]
        choices.append([min(max(one, lower), upper) for one in turned])
    return np.array(list(itertools.product(*choices))).reshape(-1, len(q))


def _timed(
    group: PlanningGroup, joints: Sequence[Joint], way: Array, speed: float
) -> Path:
    """Return the motion along a free path, with corners cut as far as possible."""
    deviations = [_CUT] * (len(way) - 2)
    while True:
        smooth = SmoothWay(way, deviations)
        blocked = [
            corner
            for corner, poses in smooth.blends(_CHORDS)
            if group.clearances.along(poses) is not None
        ]
        if not blocked:  # the straight parts have been checked before
            return time_way(joints, smooth, speed=speed)
        for corner in blocked:
            smaller = deviations[corner] / 2.0
            deviations[corner] = smaller if smaller >= _STOP else 0.0


def cost(way: Array, fastest: Array) -> float:
    """Return the duration of a path at the joints' maximum velocities [s]."""
    return float((np.abs(np.diff(way, axis=0)) / fastest).max(axis=1).sum())


def _free_goals(
    group: PlanningGroup, start: Array, goals: Array, fastest: Array
) -> list[int]:
    """Return the indices of the collision-free goals, nearest first."""
    costs = (np.abs(goals - start) / fastest).max(axis=1)
    numbers: list[int] = []
    known: dict[bytes, tuple[int, Array]] = {}
    for k in np.argsort(costs, kind="stable").tolist():
        posture = np.round(np.mod(goals[k], _TURN), 6).tobytes()
        if posture not in known:
            known[posture] = group.clearances.at(goals[k]), goals[k]
        if known[posture][0] == FREE:
            numbers.append(k)
        if len(numbers) == MOST_GOALS:
            break
    if not numbers:
        reasons = [group.explained(pair, q) for pair, q in known.values()]
        reasons = list(dict.fromkeys(reasons))
        if len(known) == 1:
            raise CollisionError(f"the target is in collision: {reasons[0]}")
        raise CollisionError(
            f"no posture of the target is free ({len(known)} were tried): "
            + "; ".join(reasons[:3])
            + (f"; and {len(reasons) - 3} more reasons" if len(reasons) > 3 else "")
        )
    return numbers


def _direct(
    group: PlanningGroup, start: Array, goals: Array, numbers: Sequence[int]
) -> Array | None:
    """Return a free straight path to one of the two nearest goals, or None."""
    for k in numbers[:2]:
        way = np.array([start, goals[k]])
        if group.clearances.along(way) is None:
            return way
    return None


def _searched(
    group: PlanningGroup,
    joints: Sequence[Joint],
    ends: tuple[Array, Array],
    *,
    options: SearchOptions,
    cancelled: Cancelled,
    begun: float,
) -> tuple[Array, int]:
    """Return the fastest of several paths, and the number of samples.

    ``ends`` contains the start and the goals.
    """
    start, goals = ends
    limits = np.array(
        [_limits(joint, here) for joint, here in zip(joints, start, strict=True)]
    ).T
    wide = np.clip([start - _TURN / 2, start + _TURN / 2], *limits)
    lower = np.minimum(wide[0], goals.min(axis=0))
    upper = np.maximum(wide[1], goals.max(axis=0))
    fastest = np.array([joint.max_velocity for joint in joints])
    ways: list[tuple[float, int, Array]] = []
    samples = 0
    looked = group.clearances.poses

    def left() -> float:
        return options.timeout - (time.perf_counter() - begun)

    def shorter(way: Array, tries: int, seed: int) -> tuple[float, int, Array]:
        way = group.clearances.shorten(
            way, tries=tries, seed=seed, timeout=left(), cancelled=cancelled
        )
        way = _without_repeats(way)
        return cost(way, fastest), seed, way

    for restart in range(options.restarts):
        seed = options.seed * 1_000_003 + restart
        found = group.clearances.search(
            start,
            goals,
            (lower, upper),
            beside=BESIDE,
            seed=seed,
            longest=LONGEST,
            most_nodes=MOST_NODES,
            timeout=left(),
            cancelled=cancelled,
        )
        samples += found.samples
        if found.ended is Ended.CANCELLED:
            raise PlanningError("planning was cancelled")
        if found.ended is Ended.FOUND:
            ways.append(shorter(found.way, 0, seed))
        elif found.ended is Ended.TIMEOUT:
            break
        if ways and group.clearances.poses - looked > ENOUGH:
            break
    if not ways:
        raise PlanningError(
            f"no way found in {time.perf_counter() - begun:.1f} s, with {samples} "
            "samples: there may be none; a longer timeout, a smaller clearance, or "
            "another target may help"
        )
    _, seed, best = min(ways, key=lambda item: item[:2])
    return shorter(best, _TRIES, seed)[2], samples


def _without_repeats(way: Array) -> Array:
    keep = np.append(True, np.abs(np.diff(way, axis=0)).max(axis=1) > _SAME)
    keep[-1] = True
    kept = way[keep]
    if len(kept) > 2 and np.abs(kept[-1] - kept[-2]).max() <= _SAME:
        kept = np.delete(kept, -2, axis=0)
    return np.asarray(kept)


def _limits(joint: Joint, here: float) -> tuple[float, float]:
    """Return the limits of a joint [rad | m]; by default, one turn on each side."""
    lower, upper = joint.limits.lower, joint.limits.upper
    if joint.type is JointType.CONTINUOUS or not math.isfinite(upper - lower):
        return here - _TURN, here + _TURN
    return lower, upper
