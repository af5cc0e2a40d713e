"""Behaviour cloning of the experts: LeRobot's ACT on their episodes, and its success.

For each task and seed: collect episodes of the expert, train with LeRobot's own
program, evaluate the checkpoints.  It needs an environment with LeRobot
(docs/how-to/policies.md) and prints one JSON object per checkpoint::

    python -m benchmarks.baselines --tasks Lift Push --seeds 0 1 2 --folder baselines
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

from tool0.collect import collect
from tool0.policy import RunOptions, evaluate

ACT = (
    "--policy.type=act --policy.device=cpu --policy.push_to_hub=false "
    "--policy.use_vae=false --policy.dim_model=128 --policy.n_heads=4 "
    "--policy.dim_feedforward=256 --policy.n_encoder_layers=2 --policy.chunk_size=10 "
    "--policy.n_action_steps=10 --policy.optimizer_lr=3e-4 --batch_size=64 "
    "--num_workers=0 --wandb.enable=false"
)
"""A small one, which a processor trains in minutes."""
FIRST_SEED = 100_000
"""Of the episodes in which policies are evaluated; `collect` hashes its seeds."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", nargs="+", default=["Lift"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2])
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--episodes", type=int, default=200, help="of the expert")
    parser.add_argument("--steps", type=int, default=3000, help="of the optimizer")
    parser.add_argument("--checkpoints", type=int, default=3)
    parser.add_argument("--evaluated", type=int, default=50, help="episodes")
    given = parser.parse_args()
    for task in given.tasks:
        for seed in given.seeds:
            _train_and_evaluate(task, seed, given)


def _train_and_evaluate(task: str, seed: int, given: argparse.Namespace) -> None:
    folder = given.folder / f"{task}_{seed}"
    collect(
        task,
        given.episodes,
        folder / "episodes",
        seed=seed,
        format="lerobot",
        workers=1,
    )
    every = given.steps // given.checkpoints
    start = time.monotonic()
    words = (
        f"{ACT} --seed={seed} --steps={given.steps} --save_freq={every} "
        f"--dataset.repo_id=tool0/{task} --dataset.root={folder / 'episodes'} "
        f"--output_dir={folder / 'training'}"
    )
    program = Path(sys.executable).parent / "lerobot-train"
    with (folder / "training.log").open("w") as log:
        subprocess.run(
            [program, *words.split()], stdout=log, stderr=subprocess.STDOUT, check=True
        )
    elapsed = time.monotonic() - start
    for checkpoint in sorted((folder / "training/checkpoints").glob("[0-9]*")):
        report = evaluate(
            f"lerobot:{checkpoint / 'pretrained_model'}",
            task,
            range(FIRST_SEED, FIRST_SEED + given.evaluated),
            run=RunOptions(clips=True),
        )
        row = {
            "task": task,
            "seed": seed,
            "steps": int(checkpoint.name),
            "training_seconds": round(elapsed),
            **report.as_json(),
        }
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
