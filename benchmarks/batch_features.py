"""Measures the cost of a batch's features, compared with a batch without them.

The cost is the processor time of commands, steps and readings, with an action every
50 ms.  The two batches alternate, and the result is the median of the ratios of all
rounds.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np

import tool0

ACTION = 0.05
"""Simulated time of one round, which is one action at 20 Hz [s]."""
WARM_UP = 3
"""Number of rounds before the first round that is measured."""
Action = Callable[[tool0.Batch, np.random.Generator], None]


def move(batch: tool0.Batch, rng: np.random.Generator) -> None:
    """Command the arms to targets near the start pose, with target velocities."""
    targets = _targets(batch, rng)
    batch.command(targets, velocities=np.zeros_like(targets), duration=0.05)
    batch.run(ACTION)


def follow(batch: tool0.Batch, rng: np.random.Generator) -> None:
    """Make the arms follow trajectories of five points."""
    ends = _targets(batch, rng)[:, None]
    here = _arm_positions(batch)[:, None]
    points = here + np.linspace(0.2, 1.0, 5)[:, None] * (ends - here)
    batch.follow(points, np.linspace(0.01, 0.05, 5).tolist())
    batch.run(ACTION)


def grip(batch: tool0.Batch, rng: np.random.Generator) -> None:
    """Command the arms to targets, and the grippers to random openings."""
    batch.move_gripper(rng.uniform(0.0, 0.08, batch.n))
    move(batch, rng)


def sense(batch: tool0.Batch, rng: np.random.Generator) -> None:
    """Command the arms, and read the wrenches on the tools at 125 Hz."""
    targets = _targets(batch, rng)
    batch.command(targets, velocities=np.zeros_like(targets), duration=0.05)
    for _ in range(6):
        batch.run(0.008)
        batch.tool_wrench()


def feel(batch: tool0.Batch, rng: np.random.Generator) -> None:
    """Command the arms, and read force-torque sensors that sample at 125 Hz."""
    batch.force_torque.read()  # the first call starts the sensors
    move(batch, rng)


def _arm_positions(batch: tool0.Batch) -> np.ndarray:
    columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
    return batch.position[:, columns]


def _targets(batch: tool0.Batch, rng: np.random.Generator) -> np.ndarray:
    """Return targets near the start pose, which is stored in the first call."""
    q = _arm_positions(batch)
    home = _HOMES.setdefault(batch, q)
    return home + rng.uniform(-0.03, 0.03, q.shape)


_HOMES: dict[tool0.Batch, np.ndarray] = {}


@dataclass(frozen=True, kw_only=True)
class Feature:
    """The actions of a batch with a feature and of a batch without the feature."""

    action: Action
    plain: Action = move
    description: tool0.DescriptionConfig = field(
        default_factory=tool0.DescriptionConfig
    )
    control: tool0.ControlConfig = field(default_factory=tool0.ControlConfig)


FEATURES: Mapping[str, Feature] = {
    "nothing else": Feature(action=move),
    "controllers of ROS 2": Feature(
        action=move, description=tool0.DescriptionConfig(ros2_control=True)
    ),
    "tool_wrench at 125 Hz": Feature(action=sense),
    "force-torque sensor at 125 Hz": Feature(action=feel),
    "follow": Feature(action=follow),
    "GripperActionController": Feature(
        action=grip, plain=grip, control=tool0.ControlConfig(gripper_action=True)
    ),
}


def ratio(feature: Feature, n: int, rounds: int) -> tuple[float, float]:
    """Return the ratio of processor times with and without a feature.

    The second result is half the interquartile range.

    The copies have the same targets in both batches, and each batch has one thread.
    """
    with ExitStack() as stack:
        batches = [
            stack.enter_context(tool0.Batch(n, threads=1)),
            stack.enter_context(
                tool0.Batch(
                    n,
                    description=feature.description,
                    control=feature.control,
                    threads=1,
                )
            ),
        ]
        actions = feature.plain, feature.action
        found = []
        for number in range(WARM_UP + rounds):
            times = []
            for batch, action in zip(batches, actions, strict=True):
                start = time.process_time()
                action(batch, np.random.default_rng(number))
                times.append(time.process_time() - start)
            if number >= WARM_UP:
                found.append(times[1] / times[0])
        for batch in batches:
            _HOMES.pop(batch, None)
    low, _, high = statistics.quantiles(found, n=4)
    return statistics.median(found), (high - low) / 2.0


def main() -> None:
    """Print the ratio of all features, or of the features on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("features", nargs="*", default=list(FEATURES))
    parser.add_argument("--copies", type=int, default=32)
    parser.add_argument("--rounds", type=int, default=21)
    options = parser.parse_args()
    for name in options.features:
        middle, spread = ratio(FEATURES[name], options.copies, options.rounds)
        print(f"{name}: {middle:.2f} ± {spread:.2f} x", flush=True)


if __name__ == "__main__":
    main()
