"""Stores runs of methods and their learning curves in two files, and makes a table."""

from __future__ import annotations

import csv
import datetime
import json
import os
from collections import defaultdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from tool0.policy.report import wilson

RUNS, CURVES = "runs.jsonl", "curves.csv"
CURVE = ("method", "task", "seed", "actions", "success", "reward", "cpu_seconds")
"""Columns of the curves.  The columns contain the number of actions of all copies
together, the success rate and mean return of the last hundred episodes, and the
processor time since the start [s]."""
PROGRAMS = ("tool0", "mujoco", "gymnasium", "numpy", "torch", "stable-baselines3")
FIRST_START = 100_000
"""Seed of the first episode of an evaluation.  This seed differs from the seeds of
``collect``, which are hashed."""
APART = 10_000
"""Difference between the first seeds of two evaluations, so that runs have different
start states."""


def starts(seed: int, n: int) -> range:
    """Return the seeds of the n episodes in which a run is evaluated."""
    first = FIRST_START + APART * seed
    return range(first, first + n)


def cpu_seconds() -> float:
    """Return the processor time of this process and of its ended children [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def write_run(folder: Path, row: dict[str, Any]) -> None:
    """Append one run with date and versions to a folder's runs, and print the run."""
    row = {**row, "date": datetime.datetime.now(datetime.UTC).date().isoformat()}
    row["versions"] = {name: _version(name) for name in PROGRAMS if _version(name)}
    with (folder / RUNS).open("a") as file:
        print(json.dumps(row), file=file)
    print(json.dumps(row), flush=True)


def write_point(folder: Path, *values: object) -> None:
    """Append one point of a curve, with values for the columns ``CURVE``."""
    path = folder / CURVES
    is_new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.writer(file)
        if is_new:
            writer.writerow(CURVE)
        writer.writerow(values)


def runs(folder: Path) -> dict[tuple[str, str], list[dict[str, Any]]]:
    """Return the runs by task and method.

    Only the last evaluation of a run is included.
    """
    last: dict[tuple[str, str, int], dict[str, Any]] = {}
    with (folder / RUNS).open() as file:
        for line in file:
            row = json.loads(line)
            last[row["task"], row["method"], row["seed"]] = row
    found: dict[tuple[str, str], list[dict[str, Any]]] = defaultdict(list)
    for (task, method, _), row in sorted(last.items()):
        found[task, method].append(row)
    return found


def curves(folder: Path) -> dict[tuple[str, str], dict[int, list[tuple[float, float]]]]:
    """Return the points (actions, success) by task and method, and then by seed."""
    found: dict[tuple[str, str], dict[int, list[tuple[float, float]]]]
    found = defaultdict(lambda: defaultdict(list))
    with (folder / CURVES).open(newline="") as file:
        for row in csv.DictReader(file):
            point = float(row["actions"]), float(row["success"])
            found[row["task"], row["method"]][int(row["seed"])].append(point)
    return found


def table(folder: Path) -> str:
    """Return a Markdown table of the runs, with a row for each task and method."""
    lines = [
        "| task | method | success by seed | all | actions in the task | CPU min |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for (task, method), rows in runs(folder).items():
        each = ", ".join(f"{row['succeeded'] / row['evaluated']:.0%}" for row in rows)
        n_succeeded = sum(row["succeeded"] for row in rows)
        n = sum(row["evaluated"] for row in rows)
        low, high = wilson(n_succeeded, n)
        minutes = [row["cpu_seconds"] / 60.0 for row in rows]
        actions = sorted({row["actions"] for row in rows})
        lines.append(
            f"| {task} | {method.upper()} | {each} | {n_succeeded / n:.1%} of {n} "
            f"({low:.1%} … {high:.1%}) | {_range(actions, ',.0f')} "
            f"| {_range(minutes, '.1f')} |"
        )
    return "\n".join(lines)


def _range(values: list[float], form: str) -> str:
    """Return the range of the values as text, or the value if there is only one."""
    low, high = (
        format(end, form).replace(",", " ") for end in (min(values), max(values))
    )
    return low if low == high else f"{low} … {high}"


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
