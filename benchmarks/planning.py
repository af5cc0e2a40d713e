"""Measures collision-free motions: success rate, time, length and safety.

``python benchmarks/planning.py [N]`` prints the table of
docs/explanation/performance.md, with N problems of each set.  ``--ompl`` also runs
OMPL's RRTConnect on the same problems.
"""

from __future__ import annotations

import argparse
import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

import tool0
from benchmarks import planning_ompl
from benchmarks.planning_problems import GROUND, SETS, Problem, Workcell, problems
from tool0.errors import (
    CollisionError,
    PenetrationError,
    PlanningError,
    UnreachableError,
)
from tool0.kernel.clearance import Cancelled
from tool0.kinematics.chain import Array
from tool0.motion.path import Path
from tool0.planning import planner
from tool0.planning.planner import FreeMotion, SearchOptions, plan_free_motion
from tool0.planning.world import CLEARANCE, PlanningGroup, Rules
from tool0.scene import Box, Scene

N_PROBLEMS = 100
IN_TIME = 2.0
"""Processor time in which a problem must be solved [s]."""
TWELVE_IN_TIME = 5.0
"""Processor time in which a problem of two arms must be solved [s]."""
CROSSING = ("left=ur5+2f85@0,0.4,0", "right=ur5+2f85@0,-0.4,0")
LONGEST = 60.0
"""Time limit of a search [wall s].  The limit is long because the machine may be
busy."""
RESTARTS = 20
ASIDE = 0.15
"""Distance from the target at which a motion with a held cube ends [m]."""
ABOVE = (0.0, 0.0, 2.0)
"""Position at which there are no objects [m]."""
STEP = 0.001
"""Distance between two poses of the independent check [rad]."""


@dataclass(frozen=True)
class Solved:
    """Result of one problem."""

    problem: Problem
    motion: FreeMotion | None
    seconds: float
    """Processor time of inverse kinematics, search, shortcuts and timing [s]."""
    ratio: float = float("nan")
    """Length, divided by the length of the best motion of ``RESTARTS`` other seeds."""
    violations: int = 0
    """Number of poses, found with MuJoCo alone, that are nearer than the clearance."""


@dataclass(frozen=True)
class Report:
    """The results of a set of problems."""

    name: str
    solved: tuple[Solved, ...]

    @property
    def share(self) -> float:
        """Share of the problems that are solved within ``IN_TIME``."""
        return float(
            np.mean([s.motion is not None and s.seconds < IN_TIME for s in self.solved])
        )

    def time(self, quantile: float) -> float:
        """Return a quantile of the processor time [s]."""
        return float(np.quantile([s.seconds for s in self.solved], quantile))

    @property
    def ratio(self) -> float:
        """Median ratio of the lengths of motions to the best lengths.

        The best length is the shortest length with ``RESTARTS`` other seeds.
        """
        return float(np.nanmedian([s.ratio for s in self.solved]))

    @property
    def violations(self) -> int:
        """Number of poses of all plans that are nearer than the clearance."""
        return sum(s.violations for s in self.solved)

    def __str__(self) -> str:
        return (
            f"| {self.name} | {len(self.solved)} | {100 * self.share:.0f} % "
            f"| {1e3 * self.time(0.5):.0f} / {1e3 * self.time(0.95):.0f} ms "
            f"| {self.ratio:.2f} | {self.violations} |"
        )


def report(name: str, n: int, *, seed: int = 0, compare: bool = True) -> Report:
    """Solve and check ``n`` problems of a set.

    Args:
        name: Name of a set in ``SETS``.
        n: Number of problems.
        seed: Seed of the problems.
        compare: Whether to compare lengths with the lengths of other seeds.
    """
    cell = Workcell()
    return Report(
        name,
        tuple(solve(cell, each, compare=compare) for each in problems(name, n, seed)),
    )


def solve(cell: Workcell, problem: Problem, *, compare: bool = True) -> Solved:
    """Solve one problem, and check the motion."""
    group = cell.group(cell.world(), problem.objects, Rules())
    begun = time.thread_time()
    motion = attempt(cell, group, problem)
    seconds = time.thread_time() - begun
    if motion is None:
        return Solved(problem, None, seconds)
    ratio = float("nan")
    if compare:
        others = [
            attempt(cell, group, problem, seed=1 + k, restarts=1)
            for k in range(RESTARTS)
        ]
        lengths = [length(other) for other in (*others, motion) if other is not None]
        ratio = length(motion) / min(lengths)
    return Solved(problem, motion, seconds, ratio, violations(cell, group, motion.path))


def attempt(
    cell: Workcell,
    group: PlanningGroup,
    problem: Problem,
    *,
    seed: int = 0,
    restarts: int = planner.RESTARTS,
) -> FreeMotion | None:
    """Return a motion; None if there was not enough time."""
    try:
        return plan_free_motion(
            group,
            cell.chain.joints,
            problem.start,
            cell.goals(problem.T_root_flange, problem.start),
            options=SearchOptions(timeout=LONGEST, seed=seed, restarts=restarts),
            cancelled=Cancelled(),
        )
    except PlanningError:
        return None


def length(motion: FreeMotion) -> float:
    """Return the length of a motion's path in joint space [rad]."""
    return float(np.linalg.norm(np.diff(motion.waypoints, axis=0), axis=1).sum())


def violations(
    cell: Workcell, group: PlanningGroup, path: Path, clearance: float = CLEARANCE
) -> int:
    """Return the number of poses that are nearer than ``clearance``.

    The poses on the path are 1 mrad apart.

    Only MuJoCo measures the distances.  If the bounding spheres of two shapes are not
    far enough apart, MuJoCo measures the distance of the two shapes.
    """
    model = group.owner.model
    data = mujoco.MjData(model)
    data.qpos[:] = group.owner.data.qpos
    addresses = group.owner.addresses(cell.chain.joint_names)
    watched = set(map(frozenset, group.names))
    pairs = np.array(
        [
            (one.geom, two.geom)
            for one, two in itertools.combinations(group.owner.shapes, 2)
            if frozenset((one.owner, two.owner)) in watched
        ]
    )
    first, second = pairs.T
    radii = model.geom_rbound
    is_plane = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
    near = radii[first] + radii[second] + clearance
    near[is_plane[first] | is_plane[second]] = np.inf
    found = 0
    for q in densely(path):
        data.qpos[addresses] = q
        mujoco.mj_kinematics(model, data)
        at = data.geom_xpos
        apart = np.linalg.norm(at[first] - at[second], axis=1)
        found += any(
            mujoco.mj_geomDistance(model, data, one, two, 2.0 * clearance, None)
            < clearance - 1e-7
            for one, two in pairs[apart < near].tolist()
        )
    return found


def densely(path: Path) -> Array:
    """Return poses along a path, shape (n, 6).

    In each joint, two successive poses are at most ``STEP`` apart.
    """
    fastest = np.abs(path.velocities).max()
    n = int(np.ceil(1.2 * fastest * path.duration / STEP))
    q = path.at(np.linspace(0.0, path.duration, n)).positions
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(q, axis=0)).max(axis=1))])
    wanted = np.append(np.arange(0.0, way[-1], STEP), way[-1])
    return np.asarray(q[np.minimum(np.searchsorted(way, wanted), len(q) - 1)])


def executed(n: int, *, engine: str = "mujoco", seed: int = 0) -> tuple[int, int]:
    """Execute the plans of ``n`` problems per set, half of them with a held cube.

    Returns:
        The number of executed plans, and the number of contacts during their execution.
    """
    count = contacts = 0
    for name in SETS:
        for k, problem in enumerate(problems(name, n, seed)):
            found = execute(problem, engine, hold=k % 2 == 1)
            if found is not None:
                count, contacts = count + 1, contacts + found
    return count, contacts


def execute(problem: Problem, engine: str, *, hold: bool = False) -> int | None:
    """Plan and execute a problem's motion.

    Return the number of unexpected contacts.

    With a held cube, the motion ends ``ASIDE`` before the target, because there may be
    an object at the target.  The result is None if this position cannot be reached or
    if the cube was not gripped.  Some motions start with an object between the pads.
    """
    cell = Workcell()
    start = dict(zip(cell.chain.joint_names, problem.start.tolist(), strict=True))
    with tool0.bringup(
        engine=engine,
        scene=Scene(problem.objects),
        initial_pose=start,
        simulation=tool0.SimulationConfig(spawn_z=-GROUND, realtime=False),
    ) as robot:
        target = problem.T_root_flange.copy()
        if hold:
            target[:3, 3] -= ASIDE * target[:3, 2]
            robot.gripper.move(opening=0.02, force=40.0)
            until = robot.time + 1.0
            while robot.gripper.opening > 0.0425 and robot.time < until:
                robot.run(0.004)
            pads = robot.arm.pose(tool=robot.gripper.tcp())
            try:
                robot.scene.add("held", Box(size=(0.04,) * 3), xyz=ABOVE, mass=0.1)
                robot.scene.place("held", pads.position, pads.quat_wxyz)
            except PenetrationError:
                return None
            robot.run(1.0)
            if math.dist(robot.scene.pose("held").position, pads.position) > 0.03:
                return None
        try:
            plan = robot.arm.plan(target, speed=1.0, timeout=LONGEST)
        except (CollisionError, UnreachableError, PlanningError):
            if hold:
                return None
            raise
        before = _touching(robot)
        goal = robot.arm.execute(plan)
        seen: set[frozenset[str]] = set()
        while not goal.status.is_terminal:
            robot.run(0.02)
            seen |= _touching(robot)
        if goal.status is not tool0.GoalStatus.SUCCEEDED:
            raise RuntimeError(f"{problem.name}: {goal.wait()}")
        return len(seen - before)


def _touching(robot: tool0.Robot) -> set[frozenset[str]]:
    return {frozenset((contact.first, contact.second)) for contact in robot.contacts()}


def twelve_joints(n: int, seed: int = 0) -> float:
    """Return the share of ``n`` plans of two arms that are found in time.

    The limit is 5 s of processor time.

    Two arms that stand next to each other reach across each other, one arm above the
    other arm, and change places.  Pairs of postures that collide are not used.
    """
    rng = np.random.default_rng(seed)
    names = Workcell().chain.joint_names

    def postures(upper: str) -> dict[str, float]:
        up, down = rng.uniform(-1.55, -1.3), rng.uniform(-1.0, -0.85)
        elbow = rng.uniform(1.4, 1.7)
        found: dict[str, float] = {}
        for arm, side in (("left", -1.0), ("right", 1.0)):
            lift = up if arm == upper else down
            pan, turn = side * rng.uniform(0.4, 0.75), rng.uniform(-1.0, 1.0)
            q = (pan, lift, elbow, -1.5 - lift - elbow, -1.57, turn)
            found |= {f"{arm}_{name}": x for name, x in zip(names, q, strict=True)}
        return found

    in_time: list[bool] = []
    with tool0.bringup(
        description=tool0.DescriptionConfig(robots=CROSSING),
        simulation=tool0.SimulationConfig(spawn_z=-GROUND, realtime=False),
    ) as robot:
        while len(in_time) < n:
            start, end = postures("left"), postures("right")
            targets = [
                robot.arms[arm].target({k: end[k] for k in end if k.startswith(arm)})
                for arm in ("left", "right")
            ]
            begun = time.thread_time()
            try:
                robot.reset(start)
                begun = time.thread_time()
                robot.plan(targets, timeout=LONGEST)
            except (CollisionError, PenetrationError):
                continue
            except PlanningError:
                in_time.append(False)
            else:
                in_time.append(time.thread_time() - begun < TWELVE_IN_TIME)
    return float(np.mean(in_time))


def reports(n: int, seed: int = 0) -> Iterator[Report]:
    """Yield the report of each set."""
    for name in SETS:
        yield report(name, n, seed=seed)


def main() -> None:
    """Print the results as a Markdown table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("n", nargs="?", type=int, default=N_PROBLEMS)
    parser.add_argument("--ompl", action="store_true")
    parser.add_argument("--execute", action="store_true")
    args = parser.parse_args()
    print(
        f"| set | problems | within {IN_TIME:g} s | median / p95 "
        f"| length ÷ best of {RESTARTS} | violations |"
    )
    print("| --- | --- | --- | --- | --- | --- |")
    for each in reports(args.n):
        print(each, flush=True)
    if args.ompl:
        planning_ompl.main(args.n)
    if args.execute:
        count, contacts = executed(args.n)
        print(f"{count} plans executed, {contacts} contacts")
    print(f"two arms, within 5 s: {100 * twelve_joints(args.n):.0f} %")


if __name__ == "__main__":
    main()
