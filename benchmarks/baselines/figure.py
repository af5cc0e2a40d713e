"""Draws the learning curves of reinforcement learning."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

from benchmarks.baselines.results import curves

mpl.use("Agg")

from matplotlib import pyplot as plt

COLOURS = {"ppo": "#1f6fb4", "sac": "#d1580b"}
POINTS = 200
"""Number of points of the mean over the seeds."""


def draw(folder: Path, path: Path) -> None:
    """Write the curves of a folder.

    Each task has a panel, and each seed has a line.
    """
    found = curves(folder)
    tasks = sorted({task for task, _ in found})
    columns = min(3, len(tasks))
    rows = -(-len(tasks) // columns)
    figure, axes = plt.subplots(
        rows,
        columns,
        figsize=(3.2 * columns, 2.5 * rows),
        sharey=True,
        squeeze=False,
        layout="constrained",
    )
    for ax in axes.flat[len(tasks) :]:
        ax.set_visible(False)
    for ax, task in zip(axes.flat, tasks, strict=False):
        ax.set_title(task, loc="left")
        ax.set(ylim=(-0.03, 1.03), xlabel="actions in thousands")
        ax.grid(alpha=0.3)
        for method, colour in COLOURS.items():
            if by_seed := found.get((task, method)):
                _plot(ax, by_seed, method, colour)
        ax.set_xlim(left=0)
        above = {"loc": "lower right", "bbox_to_anchor": (1.03, 0.96)}
        ax.legend(fontsize="small", frameon=False, **above)
    for ax in axes[:, 0]:
        ax.set_ylabel("success rate")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _plot(
    ax: plt.Axes,
    by_seed: dict[int, list[tuple[float, float]]],
    method: str,
    colour: str,
) -> None:
    """Plot the curves of one method's seeds, and their mean over the common range."""
    lines = [np.array(points).T for points in by_seed.values()]
    for actions, success in lines:
        ax.plot(actions / 1e3, success, color=colour, alpha=0.35, linewidth=0.9)
    first = max(line[0, 0] for line in lines)
    last = min(line[0, -1] for line in lines)
    at = np.linspace(first, last, POINTS)
    mean = np.mean([np.interp(at, *line) for line in lines], axis=0)
    n = len(lines)
    label = f"{method.upper()}, " + (f"mean of {n} seeds" if n > 1 else "one seed")
    ax.plot(at / 1e3, mean, color=colour, linewidth=2.0, label=label)
