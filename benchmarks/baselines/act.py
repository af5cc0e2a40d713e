"""Behavior cloning with LeRobot's ACT, trained by LeRobot's own program.

This module needs an environment with LeRobot (docs/how-to/policies.md).  The module
writes one row for each checkpoint.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from benchmarks.baselines.results import cpu_seconds, starts, write_run
from tool0.collect import collect
from tool0.policy import RunOptions, evaluate

ACT = (
    "--policy.type=act --policy.device=cpu --policy.push_to_hub=false "
    "--policy.use_vae=false --policy.dim_model=128 --policy.n_heads=4 "
    "--policy.dim_feedforward=256 --policy.n_encoder_layers=2 --policy.chunk_size=10 "
    "--policy.n_action_steps=10 --policy.optimizer_lr=3e-4 --batch_size=64 "
    "--num_workers=0 --wandb.enable=false"
)
"""Options of a small network, which a CPU trains in minutes."""


def run(task: str, seed: int, given: argparse.Namespace) -> None:
    """Collect the expert's episodes, train on them, and evaluate the checkpoints."""
    folder = given.folder / "act" / f"{task}_{seed}"
    collected = collect(
        task,
        given.episodes,
        folder / "episodes",
        seed=seed,
        format="lerobot",
        workers=1,
    )
    start = cpu_seconds()
    every = given.steps // given.checkpoints
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
    trained = cpu_seconds()
    for checkpoint in sorted((folder / "training/checkpoints").glob("[0-9]*")):
        report = evaluate(
            f"lerobot:{checkpoint / 'pretrained_model'}",
            task,
            starts(seed, given.evaluated),
            run=RunOptions(clips=True),
        )
        row = {
            "method": "act",
            "task": task,
            "seed": seed,
            "episodes": given.episodes,
            "actions": collected.n_frames,
            "steps": int(checkpoint.name),
            "evaluated": report.n_episodes,
            "succeeded": report.n_succeeded,
            "interval": report.interval,
            "cpu_seconds": trained - start,
        }
        write_run(given.folder, row)
