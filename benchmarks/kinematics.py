"""Solves and checks the inverse kinematics of the built-in arms in random poses.

``python benchmarks/kinematics.py`` writes the table of docs/reference/robots.md.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from tool0.description.catalogue import arms
from tool0.description.loading import assemble
from tool0.errors import UnreachableError
from tool0.kinematics.chain import find_chains
from tool0.kinematics.inverse import InverseKinematics

N_POSES = 10_000


@dataclass(frozen=True)
class RoundTrip:
    """Result of solving and checking the poses of random joint positions."""

    n_missed: int
    """Number of poses for which the original positions were not found."""
    worst: float
    """Largest difference between the pose of a solution and the given pose [m, or no
    unit]."""
    mean_solutions: float
    duration: float
    """Mean wall time of one pose [s]."""


def round_trip(arm: str, n: int = N_POSES, seed: int = 0) -> RoundTrip:
    """Solve the inverse kinematics for ``n`` random poses of an arm."""
    (chain,) = find_chains(assemble(arm, gripper=None).model).values()
    solver = InverseKinematics(chain)
    postures = np.random.default_rng(seed).uniform(-np.pi, np.pi, (n, 6))
    poses = chain.forward(postures).T_base_tip
    n_missed, worst, n_solutions, duration = 0, 0.0, 0, 0.0
    for q, pose in zip(postures, poses, strict=True):
        start = perf_counter()
        try:
            solutions = solver.solutions(pose, near=q)
        except UnreachableError:
            n_missed += 1
            continue
        duration += perf_counter() - start
        found = np.array([list(item.positions.values()) for item in solutions])
        reached = chain.forward(found).T_base_tip
        worst = max(worst, float(np.abs(reached - pose).max()))
        n_missed += bool(np.abs(found[0] - q).max() > 1e-6)
        n_solutions += len(found)
    return RoundTrip(
        n_missed=n_missed,
        worst=worst,
        mean_solutions=n_solutions / n,
        duration=duration / n,
    )


def main() -> None:
    """Print the results as a Markdown table."""
    n = int(sys.argv[1]) if len(sys.argv) > 1 else N_POSES
    print("| arm | poses | missed | largest error | solutions per pose | ms per pose |")
    print("| --- | --- | --- | --- | --- | --- |")
    for arm in arms():
        trip = round_trip(arm, n)
        print(
            f"| {arm} | {n} | {trip.n_missed} | {trip.worst:.1e} "
            f"| {trip.mean_solutions:.2f} | {1e3 * trip.duration:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
