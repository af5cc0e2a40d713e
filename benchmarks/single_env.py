"""Compares one environment ``tool0/Lift-v0`` with others and with its images.

The measured quantity is the processor time per action with random actions.  The
environments alternate, each in a separate process.  Install the other environments in
separate virtual environments:

    python -m venv fetch && fetch/bin/pip install gymnasium-robotics "mujoco<=3.10"
    python -m venv suite && suite/bin/pip install robosuite==1.5.2 "numpy<2"
    suite/bin/pip install --no-deps mujoco==3.3.2
    python -m benchmarks.single_env --fetch fetch/bin/python --robosuite …
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from subprocess import PIPE, Popen

import numpy as np

ACTIONS = 50
"""Number of actions in one measurement, which is one episode."""
COPIES = 8
"""Number of copies whose images are measured."""
DT = "0.002"
"""Step of FetchPickAndPlace and of robosuite's Lift [s]."""
FETCH_RATE = "25"
"""Rate of FetchPickAndPlace's actions [Hz]: 20 steps of 2 ms."""
LIFT = "tool0.gym:tool0/Lift-v0"
OURS = {
    "ours, 1 ms": ["tool0"],
    "ours, 2 ms": ["tool0", f"dt={DT}"],
    "ours, 2 ms, 25 Hz": ["tool0", f"dt={DT}", f"control_rate={FETCH_RATE}"],
    "ours, 2 ms, UR5e, joints": ["tool0", f"dt={DT}", "arm=ur5e", "action=joint"],
}


def main() -> None:
    """Print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fetch", help="Python with gymnasium-robotics")
    parser.add_argument("--robosuite", help="Python with robosuite")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    commands = {name: [sys.executable, *words] for name, words in OURS.items()}
    for other in ("fetch", "robosuite"):
        if python := getattr(options, other):
            commands[other] = [python, other]
    times = _times(commands, options.rounds)
    for name, values in times.items():
        least, middle = min(values), statistics.median(values)
        print(f"{name}: {least:.2f} ms at least, median {middle:.2f} ms per action")
    pairs = [
        ("fetch", "ours, 1 ms"),
        ("fetch", "ours, 2 ms"),
        ("fetch", "ours, 2 ms, 25 Hz"),
        ("robosuite", "ours, 2 ms, UR5e, joints"),
    ]
    for other, own in pairs:
        if other in times:
            ratios = [a / b for a, b in zip(times[other], times[own], strict=True)]
            print(f"{own}, actions/s ÷ {other}'s: {statistics.median(ratios):.2f}")
    print(f"images of {COPIES} copies ÷ their actions: {images_ratio():.1f}")


def images_ratio(rounds: int = 15) -> float:
    """Return the median time of images, divided by the time of an action.

    The images have 96 by 96 pixels.
    """
    import gymnasium

    options = {"num_envs": COPIES, "threads": 1}
    many = gymnasium.make_vec(LIFT, observation="image", **options)
    plain = gymnasium.make_vec(LIFT, **options)
    rng, found = np.random.default_rng(0), []
    for environments in (many, plain):
        environments.reset(seed=0)
    batch = many.unwrapped.copies.batch
    for _ in range(rounds):
        action = rng.uniform(-1.0, 1.0, plain.action_space.shape)
        begin = time.process_time()
        plain.step(action)
        middle = time.process_time()
        batch.render_all("scene")
        found.append((time.process_time() - middle) / (middle - begin))
        many.step(action)
    many.close()
    plain.close()
    return statistics.median(found[1:])


def _times(commands: dict[str, list[str]], rounds: int) -> dict[str, list[float]]:
    """Return the processor time per action [ms] of each command, for each round."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    with ExitStack() as stack:
        processes = {
            name: stack.enter_context(
                Popen(
                    # -I: this file's folder must not hide modules
                    [python, "-I", __file__, "--serve", *words],
                    stdin=PIPE,
                    stdout=PIPE,
                    stderr=subprocess.DEVNULL,
                    text=True,
                    env=environment,
                )
            )
            for name, (python, *words) in commands.items()
        }
        found: dict[str, list[float]] = {name: [] for name in processes}
        for number in range(rounds + 1):
            for name, process in processes.items():
                value = _next(name, process)
                if number:  # the first value is a warm-up
                    found[name].append(value)
        for process in processes.values():
            process.kill()
    return found


def _next(name: str, process: Popen[str]) -> float:
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("\n")
    process.stdin.flush()
    for line in process.stdout:
        if line.startswith("milliseconds "):
            return float(line.split()[1])
    raise RuntimeError(f"{name} ended with {process.wait()}")


def _serve(kind: str, *words: str) -> None:
    """Run one episode for each line of input.

    This function runs in the process of an environment.
    """
    step, reset, width = {
        "tool0": _ours,
        "fetch": _fetch,
        "robosuite": _robosuite,
    }[kind](*words)
    rng = np.random.default_rng(0)
    for number, _ in enumerate(sys.stdin):
        reset(number)
        actions = rng.uniform(-1.0, 1.0, (ACTIONS, width)).astype(np.float32)
        begin, done = time.process_time(), 0
        for action in actions:
            done += 1
            if step(action):
                break
        elapsed = time.process_time() - begin
        print("milliseconds", 1e3 * elapsed / done, flush=True)


Environment = tuple[Callable[[np.ndarray], bool], Callable[[int], object], int]
"""Function that executes an action and returns whether the episode ends, function that
starts an episode, and number of components of an action."""


def _ours(*words: str) -> Environment:
    sys.path.insert(0, str(Path(__file__).parent.parent / "src"))
    options: dict[str, object] = dict(word.split("=") for word in words)
    for name in ("dt", "control_rate"):
        if name in options:
            options[name] = float(str(options[name]))
    return _gymnasium(LIFT, options)


def _fetch() -> Environment:
    import gymnasium
    import gymnasium_robotics

    gymnasium.register_envs(gymnasium_robotics)
    return _gymnasium("FetchPickAndPlace-v4", {})


def _gymnasium(name: str, options: dict[str, object]) -> Environment:
    import gymnasium

    env = gymnasium.make(name, **options)

    def step(action: np.ndarray) -> bool:
        _, _, terminated, truncated, _ = env.step(action)
        return bool(terminated or truncated)

    return step, lambda seed: env.reset(seed=seed), env.action_space.shape[0]


def _robosuite() -> Environment:
    import robosuite
    from robosuite.controllers import (
        load_composite_controller_config,
        load_part_controller_config,
    )

    config = load_composite_controller_config(controller="BASIC")
    part = load_part_controller_config(default_controller="JOINT_POSITION")
    config["body_parts"] = {"right": {**part, "gripper": {"type": "GRIP"}}}
    lift = robosuite.make(
        "Lift",
        robots="UR5e",
        gripper_types="Robotiq85Gripper",
        controller_configs=config,
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
        ignore_done=True,
        horizon=10**9,
    )

    def step(action: np.ndarray) -> bool:
        lift.step(action)
        return False

    return step, lambda seed: lift.reset(), len(lift.action_spec[0])


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        _serve(*sys.argv[2:])
    else:
        main()
