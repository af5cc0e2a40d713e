"""Runs OMPL's RRTConnect on the same problems, with the same distance computation.

OMPL is used through its Python wheel.  tool0's kernel decides whether a motion is free.
"""

from __future__ import annotations

import importlib.util
import statistics
import time
from typing import Any

import numpy as np

from benchmarks.planning_problems import SETS, Problem, Workcell, problems
from tool0.kernel.clearance import FREE, Cancelled, Ended
from tool0.planning import planner
from tool0.planning.world import Rules

LONGEST = 20.0
"""Time limit of a search [wall s]."""


def is_installed() -> bool:
    """Return whether OMPL is installed."""
    return importlib.util.find_spec("ompl") is not None


def seconds(cell: Workcell, problem: Problem) -> tuple[float | None, float | None]:
    """Return the processor times of OMPL's search and of tool0's search [s].

    The time of a search without a result is None.

    OMPL and tool0 search once to the same goals, without shortcuts and timing.
    """
    group = cell.group(cell.world(), problem.objects, Rules())
    group.begin(problem.start)
    goals = np.array(
        [
            q
            for q in cell.goals(problem.T_root_flange, problem.start)
            if group.clearances.at(q) == FREE
        ]
    )
    goals = goals[np.abs(goals - problem.start).max(axis=1).argsort()][:24]
    lower = np.minimum(problem.start - np.pi, goals.min(axis=0))
    upper = np.maximum(problem.start + np.pi, goals.max(axis=0))
    begun = time.thread_time()
    is_solved = _search(group.clearances, problem, goals, (lower, upper))
    theirs = time.thread_time() - begun
    begun = time.thread_time()
    found = group.clearances.search(
        problem.start,
        goals,
        (lower, upper),
        beside=planner.BESIDE,
        seed=0,
        longest=planner.LONGEST,
        most_nodes=planner.MOST_NODES,
        timeout=LONGEST,
        cancelled=Cancelled(),
    )
    ours = time.thread_time() - begun
    return (
        theirs if is_solved else None,
        ours if found.ended is Ended.FOUND else None,
    )


def _search(clearances: Any, problem: Problem, goals: Any, bounds: Any) -> bool:
    from ompl import base, geometric, util

    util.setLogLevel(util.LOG_ERROR)
    n = len(problem.start)

    def values(state: Any) -> list[float]:
        return [state[k] for k in range(n)]

    class Motions(base.MotionValidator):  # type: ignore[misc]
        def checkMotion(self, one: Any, other: Any) -> bool:
            way = np.array([values(one), values(other)])
            return clearances.along(way) is None

    space = base.RealVectorStateSpace(n)
    limits = base.RealVectorBounds(n)
    for k, (lower, upper) in enumerate(zip(*bounds, strict=True)):
        limits.setLow(k, float(lower))
        limits.setHigh(k, float(upper))
    space.setBounds(limits)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: clearances.at(values(state)) == FREE)
    information = setup.getSpaceInformation()
    information.setMotionValidator(Motions(information))
    start = space.allocState()
    for k, value in enumerate(problem.start.tolist()):
        start[k] = value
    setup.setStartState(start)
    states = base.GoalStates(information)
    for goal in goals.tolist():
        state = space.allocState()
        for k, value in enumerate(goal):
            state[k] = value
        states.addState(state)
    setup.setGoal(states)
    connect = geometric.RRTConnect(information)
    connect.setRange(planner.LONGEST)
    setup.setPlanner(connect)
    setup.solve(LONGEST)
    return bool(setup.haveExactSolutionPath())


def main(n: int) -> None:
    """Print the results as a Markdown table."""
    if not is_installed():
        print("OMPL is not installed, so it is not measured")
        return
    cell = Workcell()
    print("| set | solved: OMPL, tool0 | median: OMPL ÷ tool0 |")
    print("| --- | --- | --- |")
    for name in SETS:
        pairs = [seconds(cell, each) for each in problems(name, n)]
        ratios = [theirs / ours for theirs, ours in pairs if theirs and ours]
        solved = [sum(pair[k] is not None for pair in pairs) for k in range(2)]
        print(
            f"| {name} | {solved[0]}, {solved[1]} of {len(pairs)} "
            f"| {statistics.median(ratios):.1f} |",
            flush=True,
        )
