"""No plan of moves is faster than a joint: random moves, blends and continuations."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.transform_arrays import matrix_of, rotation_vector
from tool0.errors import UnreachableError
from tool0.kinematics.chain import ArmChain, find_chains
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.moves import Move
from tool0.motion.path import Path
from tool0.motion.planner import MovePlanner

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
HOME = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])
TCP = (0.0, 0.0, 0.15, 0.0, 0.0, 0.0)
EXCESS = 1.02
N_PLANS = 15
"""Plans of each seed; with 300, and other seeds, the largest excess is 1.003."""


@cache
def chain(arm: str) -> ArmChain:
    model = load_description(DescriptionConfig(arm=arm)).model
    return next(iter(find_chains(model).values()))


def peaks(motion: Path) -> Array:
    """Return the largest speed of each joint within the cubics, exactly."""
    times, q, qd = motion.times, motion.positions, motion.velocities
    mean = np.diff(q, axis=0) / np.diff(times)[:, None]
    before, after = qd[:-1], qd[1:]
    linear = 6.0 * mean - 4.0 * before - 2.0 * after
    square = 3.0 * (before + after) - 6.0 * mean
    with np.errstate(divide="ignore", invalid="ignore"):
        at = np.clip(np.nan_to_num(-linear / (2.0 * square)), 0.0, 1.0)
    inner = np.abs(before + at * linear + at**2 * square)
    return np.maximum(inner, np.maximum(abs(before), abs(after))).max(axis=0)


def pose(arm: ArmChain, q: Array) -> tuple[float, ...]:
    T = arm.forward(q[None]).T_base_tip[0] @ matrix_of(TCP)
    return (*T[:3, 3].tolist(), *rotation_vector(T[:3, :3]).tolist())


def random_move(rng: np.random.Generator, arm: ArmChain, q: Array) -> Move:
    target = q + rng.uniform(-1.0, 1.0, 6) * rng.uniform(0.1, 1.2)
    radius = float(rng.choice([0.0, 0.02, 0.05, 0.2]))
    kind = rng.choice(["joint", "linear", "process", "circular"])
    if kind == "joint":
        a, v = float(rng.uniform(0.5, 40.0)), float(rng.uniform(0.3, 6.0))
        return Move(kind="joint", q=tuple(target), a=a, v=v, r=radius)
    via = (q + target) / 2.0 + rng.normal(0.0, 0.05, 6)
    return Move(
        kind=kind,
        pose=pose(arm, target),
        via=pose(arm, via) if kind == "circular" else None,
        a=float(rng.uniform(0.3, 10.0)),
        v=float(rng.uniform(0.05, 2.0)),
        r=radius,
    )


@pytest.mark.parametrize("arm", ["ur5", "ur10e"])
def test_no_move_and_no_blend_exceeds_a_speed(arm: str) -> None:
    rng, joints = np.random.default_rng(0), chain(arm)
    planner = MovePlanner(InverseKinematics(joints), TCP)
    fastest = np.array([joint.limits.velocity for joint in joints.joints])
    planned = 0
    while planned < N_PLANS:
        start = HOME + rng.uniform(-0.8, 0.8, 6)
        moves = [random_move(rng, joints, start) for _ in range(3)]
        try:
            plan = planner.plan(start, moves)
            later = [random_move(rng, joints, plan.end)]
            entry = plan.duration if plan.tail is None else plan.tail.entry
            rest = planner.resume(plan, rng.uniform(entry, plan.duration), later)
        except UnreachableError:
            continue
        planned += 1
        for motion in (plan, rest):
            if motion is not None:
                assert (peaks(motion.path) <= EXCESS * fastest).all()


def test_limits_of_other_files_replace_those_of_the_urdf() -> None:
    model = load_description(DescriptionConfig(arm="ur5")).model
    own = next(iter(find_chains(model).values())).joints[-1]
    slow = {own.name: replace(own.limits, velocity=0.3)}
    arm = next(iter(find_chains(model, slow).values()))
    planner = MovePlanner(InverseKinematics(arm), TCP)
    start, end = HOME, HOME + np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.5])
    for move in (
        Move(kind="joint", q=tuple(end), a=10.0, v=3.0),
        Move(kind="linear", pose=pose(arm, end), a=2.0, v=1.0),
    ):
        assert peaks(planner.plan(start, [move]).path)[-1] <= EXCESS * 0.3
