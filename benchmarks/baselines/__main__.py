"""Train and evaluate learning methods in the tasks, or show their results.

python -m benchmarks.baselines bc --tasks Lift --seeds 0 1 2 --folder baselines
python -m benchmarks.baselines ppo --tasks Reach --folder baselines
python -m benchmarks.baselines show --folder baselines --figure baselines.png

Runs are appended to runs.jsonl and curves.csv in the folder
(docs/explanation/baselines.md).
"""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path

from benchmarks.baselines.results import table
from tool0.gym.tasks import TASKS

MODULES = {
    "bc": "clone",
    "bc-fine": "clone",
    "act": "act",
    "ppo": "reinforce",
    "sac": "reinforce",
}
"""Module of each method.  Each module needs additional packages."""
CLONING = {"bc": (200, 5_000), "bc-fine": (1000, 20_000), "act": (200, 3_000)}
"""Number of the expert's episodes and of optimizer steps of each method that learns
from the expert."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="method", required=True)
    for name in MODULES:
        one = commands.add_parser(name)
        one.add_argument("--tasks", nargs="+", choices=list(TASKS), default=["Lift"])
        one.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2])
        one.add_argument("--folder", type=Path, required=True)
        one.add_argument("--evaluated", type=int, default=50, help="episodes")
        if name in CLONING:
            n, steps = CLONING[name]
            one.add_argument("--episodes", type=int, default=n, help="of the expert")
            one.add_argument(
                "--steps", type=int, default=steps, help="of the optimizer"
            )
        else:
            one.add_argument("--actions", type=int, default=60_000)
        if name == "act":
            one.add_argument("--checkpoints", type=int, default=3)
    show = commands.add_parser("show")
    show.add_argument("--folder", type=Path, required=True)
    show.add_argument("--figure", type=Path, help="file of the learning curves")
    given = parser.parse_args()
    if given.method == "show":
        print(table(given.folder))
        if given.figure is not None:
            import_module("benchmarks.baselines.figure").draw(
                given.folder, given.figure
            )
        return
    given.folder.mkdir(parents=True, exist_ok=True)
    module = import_module(f"benchmarks.baselines.{MODULES[given.method]}")
    for task in given.tasks:
        for seed in given.seeds:
            module.run(task, seed, given)


if __name__ == "__main__":
    main()
