"""Compares batches and environments on a GPU with batches and environments on the CPU.

Run this script on a machine with an NVIDIA GPU and ``pip install '.[gpu,gym]'``::

    python benchmarks/gpu.py                                # cuda, 1024, 4096, 8192
    python benchmarks/gpu.py --envs Reach Lift              # env-steps/s of tasks
    python benchmarks/gpu.py --device warp:cpu --copies 4 16  # without a GPU, slowly

The batches on the CPU and on the GPU alternate, so that other programs slow down both
batches equally.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import platform
import statistics
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

import tool0

COPIES = 1024, 4096, 8192
HOST_COPIES = 256
"""Number of copies of the batch on the CPU.  The steps/s of a batch on the CPU depend
little on the number of copies."""
TICKS = 50
"""Number of ticks of one action.  The rate of actions is 20 Hz."""
ROUNDS = 5


def action(
    batch: tool0.Batch, rng: np.random.Generator, *, moves_grippers: bool
) -> float:
    """Return the time of an action, with its command, steps and reading [s]."""
    columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
    home = batch.position[:, columns]
    start = time.perf_counter()
    batch.command(home + rng.uniform(-0.1, 0.1, home.shape), duration=0.05)
    if moves_grippers:
        batch.move_gripper(rng.uniform(0.0, 0.08, batch.n))
    batch.step(TICKS)
    batch.position, batch.velocity, batch.object_position  # noqa: B018
    return time.perf_counter() - start


def compare(n: int, device: str, scene: str | None, *, moves_grippers: bool) -> None:
    """Print the steps/s of n copies, and the ratio to the steps/s of the CPU."""
    rng = np.random.default_rng(0)
    start = time.perf_counter()
    with (
        tool0.Batch(n, device=device, scene=scene) as batch,
        tool0.Batch(min(n, HOST_COPIES), scene=scene) as host,
    ):
        action(batch, rng, moves_grippers=moves_grippers)  # compiles the kernels
        ready = time.perf_counter() - start
        action(host, rng, moves_grippers=moves_grippers)
        both = batch, host
        pairs = [
            [action(each, rng, moves_grippers=moves_grippers) for each in both]
            for _ in range(ROUNDS)
        ]
        steps = round(TICKS * batch.control_period / batch.dt)
        speeds = np.array([batch.n, host.n]) * steps / np.array(pairs)
        ratio = statistics.median((speeds[:, 0] / speeds[:, 1]).tolist())
        ours, its = np.median(speeds, axis=0).tolist()
        print(
            f"{n:6d} copies: {ours:12,.0f} steps/s on {device}; {its:10,.0f} on the "
            f"CPU ({host.threads} threads, {host.n} copies); ratio {ratio:6.2f}; ready "
            f"after {ready:.1f} s; diverged {int(batch.diverged.sum())}",
            flush=True,
        )


def environment_step(env: Any, rng: np.random.Generator) -> float:
    """Return the time of a step of a vector environment with random actions [s]."""
    actions = rng.uniform(-1.0, 1.0, env.action_space.shape).astype(np.float32)
    start = time.perf_counter()
    env.step(actions)
    return time.perf_counter() - start


def physics_seconds(copies: Any) -> float:
    """Return the time of the physics in an action [s]."""
    start = time.perf_counter()
    copies.batch.step(copies.options.ticks)
    copies.batch.position  # noqa: B018  # waits for the GPU
    return time.perf_counter() - start


def compare_environments(task: str, n: int, device: str) -> None:
    """Print the env-steps/s of n copies of a task, and the ratio to the CPU's."""
    import gymnasium

    import tool0.gym  # noqa: F401  # registers the tasks

    rng = np.random.default_rng(0)
    start = time.perf_counter()
    env = gymnasium.make_vec(f"tool0/{task}-v0", num_envs=n, device=device)
    host = gymnasium.make_vec(f"tool0/{task}-v0", num_envs=min(n, HOST_COPIES))
    both = env, host
    for each in both:
        each.reset(seed=0)
        environment_step(each, rng)  # compiles the kernels
    ready = time.perf_counter() - start
    pairs = [[environment_step(each, rng) for each in both] for _ in range(ROUNDS)]
    speeds = np.array([n, host.num_envs]) / np.array(pairs)
    ratio = statistics.median((speeds[:, 0] / speeds[:, 1]).tolist())
    ours, its = np.median(speeds, axis=0).tolist()
    copies = env.unwrapped.copies
    physics = statistics.median(physics_seconds(copies) for _ in range(ROUNDS))
    whole = statistics.median(pair[0] for pair in pairs)
    outside = max(0.0, 1.0 - physics / whole)
    print(
        f"{task} {n:6d} copies: {ours:12,.1f} env-steps/s on {device}, of which "
        f"{100.0 * outside:.0f} % outside the physics; {its:10,.1f} on "
        f"the CPU ({host.num_envs} copies); ratio {ratio:6.2f}; ready after "
        f"{ready:.1f} s; diverged {int(copies.batch.diverged.sum())}",
        flush=True,
    )
    for each in both:
        each.close()


def print_machine(device: str) -> None:
    """Print the device and the versions of the packages."""
    import warp as wp

    wp.init()
    name = device.removeprefix("warp:")
    found = wp.get_cuda_device() if name == "cuda" else wp.get_device(name)
    memory = f", {found.total_memory / 2**30:.0f} GiB" if found.is_cuda else ""
    print(f"device {device}: {found.name}{memory}; CPU: {platform.machine()}")
    names = "tool0", "mujoco", "mujoco-warp", "warp-lang", "numpy"
    print(", ".join(f"{each} {importlib.metadata.version(each)}" for each in names))
    if found.is_cuda:
        print(f"CUDA driver {wp.get_cuda_driver_version()}")


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--device", default="cuda", help="cuda, cuda:1 or warp:cpu")
    parser.add_argument("--copies", type=int, nargs="+", default=COPIES)
    parser.add_argument("--scene", help="such as table_and_cubes; empty if left out")
    parser.add_argument(
        "--grippers",
        action="store_true",
        help="move the grippers, too",
    )
    parser.add_argument(
        "--envs",
        nargs="+",
        default=[],
        metavar="TASK",
        help="measure environments of these tasks instead, such as Reach Lift",
    )
    options = parser.parse_args(arguments)
    try:
        tool0.Batch(1, device=options.device).close()
    except tool0.Tool0Error as error:
        parser.exit(1, f"{error}\n")
    print_machine(options.device)
    for task in options.envs:
        for n in options.copies:
            compare_environments(task, n, options.device)
    for n in () if options.envs else options.copies:
        compare(n, options.device, options.scene, moves_grippers=options.grippers)


if __name__ == "__main__":
    main()
