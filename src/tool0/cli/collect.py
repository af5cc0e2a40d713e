"""``tool0 collect``: collect episodes of a task in parallel processes or with Ray."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TextIO, final

from tool0.cli.parameters import AsJson, Option, keywords
from tool0.cli.text import ProgressBar, counted, print_json
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.cli.outputs import CollectOutput
    from tool0.collect import Progress

LINE_PERIOD = 10.0
"""Interval between two progress lines if the output is not a terminal [wall s]."""


def collect(
    *,
    task: str,
    episodes: Annotated[int, Option(metavar="NUMBER")],
    folder: Annotated[Path | None, Option(metavar="FOLDER")] = None,
    workers: int | None = None,
    ray: Annotated[str | None, Option(metavar="ADDRESS")] = None,
    policy: str | None = None,
    env: Annotated[tuple[str, ...], Option(metavar="NAME=VALUE ...")] = (),
    seed: int = 0,
    format: Literal["parquet", "lerobot"] = "parquet",  # named like the option
    instruction: str | None = None,
    copies: int = 8,
    summary: bool = True,
    as_json: AsJson = False,
) -> None:
    """Collect episodes of a task in a folder; repeat the command to continue.

    An episode depends only on the task, the policy, the seed and the episode's number.
    The number of workers, the machines and interruptions have no effect on the content
    of an episode.

    Args:
        task: The task, such as Lift, or the id of a Gymnasium environment; MODULE:ID or
            FILE.py:ID imports the module that registers it.
        episodes: Number of episodes that the folder should contain.
        folder: Folder to create or to continue; by default, a folder named after the
            task.
        workers: Number of processes; by default, one per processor.
        ray: Collect with Ray: HOST:PORT of a cluster, or `local` to start Ray on this
            machine.
        policy: The policy: MODULE:NAME or FILE.py:NAME; by default, the task's expert.
        env: Keyword arguments of the environment, such as arm=ur5e randomise=true.
        seed: Base seed, from which the seed of each episode is derived.
        format: Format of the data set.
        instruction: Description of the task for lerobot; the default is the built-in
            description of the task.
        copies: Number of simulations that each worker runs in turn.
        summary: Print a report at the end.
        as_json: Print the report as one JSON object.
    """
    if as_json and not summary:
        raise ConfigError("--json and --no-summary exclude each other")
    from tool0.collect import collect as carry_out

    start = time.monotonic()
    with _Display(task, sys.stderr) as display:
        manifest = carry_out(
            task,
            episodes,
            folder or Path(task.rpartition(":")[2]),
            workers=workers,
            ray=ray,
            policy=policy,
            options=keywords(env),
            seed=seed,
            format=format,
            instruction=instruction,
            copies=copies,
            progress=display.show,
        )
    found: CollectOutput = {
        "folder": str(manifest.folder),
        "episodes": manifest.n_episodes,
        "succeeded": manifest.n_succeeded,
        "frames": manifest.n_frames,
        "bytes": manifest.n_bytes,
        "seconds": round(time.monotonic() - start, 3),
    }
    if as_json:
        print_json(found)
    elif summary:
        print(
            f"{manifest.folder}: {counted(manifest.n_episodes, 'episode')}, "
            f"{manifest.n_succeeded} succeeded, {counted(manifest.n_frames, 'frame')}, "
            f"{manifest.n_bytes / 1e6:.1f} MB"
        )


@final
class _Display:
    """A progress bar on a terminal; on other outputs, an occasional progress line."""

    def __init__(self, task: str, stream: TextIO) -> None:
        self._task = task
        self._stream = stream
        self._bar = ProgressBar(stream) if stream.isatty() else None
        self._next = time.monotonic() + LINE_PERIOD

    def __enter__(self) -> _Display:
        """Return itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """End the bar's line; after Ctrl-C, print how to continue."""
        if self._bar is not None:
            self._bar.__exit__(kind)
        if kind is KeyboardInterrupt:
            text = "interrupted: the same command continues"
            print(text, file=self._stream, flush=True)

    def show(self, progress: Progress) -> None:
        """Show the progress."""
        n, n_requested = progress.n_episodes, progress.n_requested
        rate = f"{n}/{n_requested} episodes, {progress.rate:.2f}/s"
        if n:
            rate += f", {progress.n_succeeded / n:.1%} succeeded"
        if self._bar is not None:
            self._bar(self._task, n / n_requested, rate)
        elif n == n_requested or time.monotonic() >= self._next:
            self._next = time.monotonic() + LINE_PERIOD
            print(f"{self._task}: {rate}", file=self._stream, flush=True)
