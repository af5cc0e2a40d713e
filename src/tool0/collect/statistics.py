"""LeRobot's statistics for normalization, per episode and for a whole data set.

The names and meanings follow lerobot 0.6.1 (lerobot/datasets/compute_stats.py).
However, the quantiles of an episode are exact, whereas lerobot estimates quantiles from
histograms.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tool0.collect.parquet import Array, is_image

Numbers = NDArray[np.float64]
Statistics = dict[str, Array]
"""Values of each statistic by name.  A statistic has one value per component or, for
images, one per color channel, scaled to 0 … 1.  ``count`` is the number of frames."""

_QUANTILES: Final = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
NAMES: Final = ("min", "max", "mean", "std", "count", *_QUANTILES)


def shape_of(values: Array) -> tuple[int, ...]:
    """Return the shape of a column's statistics other than ``count``."""
    if is_image(values):
        return (3, 1, 1)
    return values.shape[1:] or (1,)


def statistics(values: Array) -> Statistics:
    """Return the statistics of a column of shape (n_frames, …)."""
    shape, n = shape_of(values), len(values)
    found = _of_colours(values) if is_image(values) else _of_numbers(values)
    statistic = {name: value.reshape(shape) for name, value in found.items()}
    return {name: statistic.get(name, np.array([n])) for name in NAMES}


def combined(parts: Mapping[str, Array]) -> Statistics:
    """Return the combined statistics of several parts.

    As in LeRobot, a combined quantile is the mean of the parts' quantiles, weighted by
    their numbers of frames.

    Args:
        parts: Values of each statistic for k parts, shape (k, …), by name of the
            statistic.
    """
    count = parts["count"].sum(axis=0)
    weights = parts["count"].reshape(-1, *(1 for _ in parts["mean"].shape[1:]))
    weights = weights / count.sum()

    def mean_of(values: Array) -> Array:
        return np.asarray((values * weights).sum(axis=0))

    mean = mean_of(parts["mean"])
    spread = np.square(parts["std"]) + np.square(parts["mean"] - mean)
    return {
        "min": parts["min"].min(axis=0),
        "max": parts["max"].max(axis=0),
        "mean": mean,
        "std": np.sqrt(mean_of(spread)),
        "count": count,
        **{name: mean_of(parts[name]) for name in _QUANTILES},
    }


def _of_numbers(values: Array) -> dict[str, Numbers]:
    numbers = values.astype(np.float64)
    return {
        "min": numbers.min(0),
        "max": numbers.max(0),
        "mean": numbers.mean(0),
        "std": numbers.std(0),
        **{name: np.quantile(numbers, part, 0) for name, part in _QUANTILES.items()},
    }


def _of_colours(images: Array) -> dict[str, Numbers]:
    """Return the statistics of each color, from a histogram of the 256 color values."""
    levels = np.arange(256) / 255.0
    counts = np.zeros((3, 256), np.int64)
    for image in images:
        for channel in range(3):
            counts[channel] += np.bincount(image[..., channel].ravel(), minlength=256)
    total = counts[0].sum()
    mean = counts @ levels / total
    spread = np.square(levels - mean[:, None])
    until = np.cumsum(counts, axis=1)

    def level(share: float) -> Numbers:
        """Return the quantile ``share`` of the levels of the pixels."""
        needed = max(share * total, 1.0)
        return np.asarray(levels[np.argmax(until >= needed, axis=1)])

    return {
        "min": level(0.0),
        "max": level(1.0),
        "mean": mean,
        "std": np.sqrt((counts * spread).sum(axis=1) / total),
        **{name: level(part) for name, part in _QUANTILES.items()},
    }
