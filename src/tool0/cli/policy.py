"""``tool0 policy``: execute a policy in episodes of a task, or on a running bringup."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from tool0.cli import GOAL_FAILED, INTERRUPTED, OK
from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.parameters import AsJson, Option, assignments, keywords
from tool0.cli.text import counted, print_json
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.cli.outputs import PolicyRunOutput
    from tool0.policy import EpisodeRun, Report

PolicyName = Annotated[str, Option(is_positional=True, metavar="POLICY")]

_RATE: Final = 25.0


def run(
    policy: PolicyName,
    *,
    task: str | None = None,
    episodes: Annotated[int | None, Option(metavar="NUMBER")] = None,
    seed: int = 0,
    env: Annotated[tuple[str, ...], Option(metavar="NAME=VALUE ...")] = (),
    videos: Literal["none", "failures", "all"] = "none",
    rate: float | None = None,
    duration: float | None = None,
    camera: tuple[str, ...] = (),
    folder: Annotated[Path | None, Option(metavar="FOLDER")] = None,
    instruction: str | None = None,
    execute: Annotated[int | None, Option(metavar="NUMBER")] = None,
    ensemble: float | None = None,
    latency: Annotated[str, Option(metavar="SECONDS | measured")] = "0",
    keep_late: bool = False,
    clip: bool = False,
    device: str = "cpu",
    key: Annotated[tuple[str, ...], Option(metavar="NAME=VALUE ...")] = (),
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> int:
    """Execute a policy in episodes of a task (with --task) or on a running bringup.

    A policy is Python code (MODULE:NAME or FILE.py:NAME), a pretrained LeRobot policy
    (lerobot:FOLDER), or an openpi server (ws://HOST:PORT).  Ctrl-C stops the robot.

    Args:
        policy: The policy to execute.
        task: The task, such as Lift, or the id of a Gymnasium environment.
        episodes: Number of episodes, with --task; the default is 20.
        seed: Seed of the first episode; each further episode uses the next number.
        env: Keyword arguments of the environment, such as arm=ur5e observation=image.
        videos: Which episodes to record as videos in --folder.
        rate: Rate of the actions [Hz], without --task; the default is 25.
        duration: Simulated time after which the policy ends [s], without --task.
        camera: Cameras whose images the policy receives, without --task.
        folder: A new folder for observations, actions, results and the recording.
        instruction: Description of the task; the default is the built-in description of
            the task.
        execute: Number of actions to execute from each chunk before the next chunk is
            requested; by default, all actions.
        ensemble: Request a chunk in each step, and execute the weighted mean of all
            predictions for this step.  The weights are exp(-ENSEMBLE i), where i = 0 is
            the oldest prediction.
        latency: Simulated time from an observation to its actions [s], with --task;
            `measured` is the wall time that the policy takes.
        keep_late: Start each chunk with its first action, even if the chunk was
            received late.
        clip: Clip actions to their limits; without this option, an action beyond its
            limits ends the episode.
        device: Device on which a LeRobot policy runs, such as cuda.
        key: Names of the inputs that an openpi server receives, such as
            observation/image=rgb.
        as_json: Print the report as one JSON object.
    """
    from tool0.policy import ChunkOptions, RunOptions

    if task is None:
        _refuse("--task", episodes=episodes, env=env or None)
        if videos != "none":
            raise ConfigError(
                "--videos needs --task; `tool0 export` makes them of a recording"
            )
        if latency != "0":
            raise ConfigError("--latency needs --task; on a bringup time passes")
    else:
        _refuse("a bringup", rate=rate, duration=duration, camera=camera or None)
    max_steps = None
    if duration is not None:
        max_steps = max(1, round(duration * (rate or _RATE)))
    options = RunOptions(
        chunks=ChunkOptions(
            execute=execute, ensemble=ensemble, compensate=not keep_late
        ),
        latency=_latency(latency),
        clips=clip,
        max_steps=max_steps,
    )
    common = {
        "run": options,
        "folder": folder,
        "device": device,
        "keys": assignments(key, "="),
    }
    if task is None:
        return _on_bringup(
            policy,
            bringup,
            {
                **common,
                "rate": rate or _RATE,
                "cameras": camera,
                "instruction": instruction or "",
                "seed": seed,
            },
            as_json=as_json,
        )
    n = 20 if episodes is None else episodes
    if n < 1:
        raise ConfigError(f"--episodes must be 1 or more, got {n}")
    more = {
        **common,
        "options": keywords(env),
        "videos": videos,
        "instruction": instruction,
    }
    return _on_task(policy, task, range(seed, seed + n), more, as_json=as_json)


def _on_task(
    policy: str, task: str, seeds: range, options: dict[str, Any], *, as_json: bool
) -> int:
    from tool0.cli.stop_signal import StopSignal
    from tool0.policy import evaluate

    def show(found: EpisodeRun) -> None:
        if not as_json:
            print(_episode_text(found), flush=True)

    with StopSignal() as stop:
        report = evaluate(
            policy,
            task,
            seeds,
            when_ended=show,
            should_stop=lambda: stop.is_set,
            **options,
        )
        was_stopped = stop.is_set
    if as_json:
        print_json(report.as_json())
    else:
        print(_report_text(report))
    return INTERRUPTED if was_stopped else OK


def _on_bringup(
    policy: str, bringup: Bringup, options: dict[str, Any], *, as_json: bool
) -> int:
    from tool0.cli.stop_signal import StopSignal
    from tool0.policy import execute

    with contextlib.ExitStack() as stack:
        robot = stack.enter_context(bringup.connect())
        stop = stack.enter_context(StopSignal())
        found = execute(policy, robot, should_stop=lambda: stop.is_set, **options)
    if as_json:
        result: PolicyRunOutput = {
            "result": found.result,
            "reason": found.reason,
            "steps": found.n_steps,
            "held_steps": found.n_held,
        }
        print_json(result)
    else:
        print(_episode_text(found))
    if found.result == "interrupted":
        return INTERRUPTED
    return GOAL_FAILED if found.result == "stopped" else OK


def _refuse(what: str, **options: object) -> None:
    """Raise ConfigError if an option is given that applies only to ``what``."""
    for name, value in options.items():
        if value is not None:
            raise ConfigError(f"--{name} needs {what}")


def _latency(text: str) -> Any:
    if text == "measured":
        return text
    try:
        return float(text)
    except ValueError:
        raise ConfigError(
            f"--latency must be a number of seconds or 'measured', got '{text}'"
        ) from None


def _episode_text(found: EpisodeRun) -> str:
    reason = f": {found.reason}" if found.reason else ""
    held = f", {found.n_held} of them without one yet" if found.n_held else ""
    steps = counted(found.n_steps, "action")
    return f"seed {found.seed}: {found.result}{reason}, {steps}{held}"


def _report_text(report: Report) -> str:
    if not report.n_episodes:
        return "no episode has ended"
    low, high = report.interval
    median, most, _ = report.policy_time
    text = (
        f"{report.n_succeeded} of {counted(report.n_episodes, 'episode')} succeeded: "
        f"{report.success_rate:.1%}, 95 % interval {low:.1%} to {high:.1%}; the policy "
        f"took {1e3 * median:.1f} ms, 95 % below {1e3 * most:.1f} ms"
    )
    if report.n_stopped:
        text += f"; {report.n_stopped} were stopped at the limits of the actions"
    return text


policy = {"run": run}
"""Subcommand → function that executes it."""
