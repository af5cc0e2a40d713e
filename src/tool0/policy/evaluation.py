"""Evaluation of policies in episodes of a task or on a robot."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, final

from tool0.collect.encoding import encoded
from tool0.collect.policy import Policy
from tool0.collect.settings import programs, require_extra
from tool0.errors import ConfigError
from tool0.policy.callables import name_of
from tool0.policy.report import Report, report_of
from tool0.policy.robot_environment import RobotEnvironment
from tool0.policy.running import EpisodeRun, RunOptions, run_episode
from tool0.policy.source import opened
from tool0.policy.task_environment import TaskEnvironment

if TYPE_CHECKING:
    from tool0.api.robot import Robot

Videos = Literal["none", "failures", "all"]

_ROWS: Final = "episodes.jsonl"
_REPORT: Final = "report.json"


def evaluate(
    policy: str | Policy,
    task: str,
    seeds: Iterable[int],
    *,
    options: Mapping[str, Any] | None = None,
    run: RunOptions = RunOptions(),
    folder: Path | str | None = None,
    videos: Videos = "none",
    instruction: str | None = None,
    device: str = "cpu",
    keys: Mapping[str, str] | None = None,
    when_ended: Callable[[EpisodeRun], None] = lambda run: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Report:
    """Execute a policy in episodes of a task, and return its success rate and timing.

    Args:
        policy: ``module:name``, ``file.py:name``, ``lerobot:FOLDER`` or
            ``ws://HOST:PORT`` (docs/how-to/policies.md); or a function or class.
        task: Name of a built-in task, such as ``Lift``, or the id of a Gymnasium
            environment; see ``tool0.collect.collect``.
        seeds: Seeds of the episodes, one seed per episode.
        options: Keyword arguments of the environment.
        run: Options for executing the policy's actions.
        folder: New folder to which observations, actions, videos and the report are
            written.
        videos: Episodes for which videos are written to the folder.
        instruction: Instruction for the policy; the default is the instruction of the
            task.
        device: Device on which LeRobot's policies run, such as ``cuda``.
        keys: Mapping from the names that an openpi server expects to the observed
            values.
        when_ended: Callback that is called after each episode.
        should_stop: Callback that is called before each action.  If the callback
            returns True, the evaluation ends.

    Raises:
        ConfigError: If an argument is wrong, or the folder contains files.
        PolicyError: If the policy fails.
        TransportError: If the policy's server does not answer.
    """
    require_extra()
    if videos != "none" and folder is None:
        raise ConfigError("videos need a folder")
    place = None if folder is None else _Folder(Path(folder), videos)
    environment = TaskEnvironment(
        task, options or {}, instruction=instruction, draws=videos != "none"
    )
    runs: list[EpisodeRun] = []
    with closing(environment):
        source = opened(policy, device=device, keys=dict(keys or {}))
        with closing(source):
            for seed in seeds:
                if should_stop():
                    break
                found = run_episode(
                    environment, source, seed, run, should_stop=should_stop
                )
                if place is not None:
                    place.add(len(runs), found, environment)
                when_ended(found)
                runs.append(replace(found, episode=None, pictures=()))
    report = report_of(runs)
    if place is not None:
        about = {
            "policy": name_of(policy),
            "policy_sha256": source.digest,
            "task": environment.task,
            "task_sha256": environment.digest,
            "options": dict(options or {}),
            "programs": programs(),
            **_plain(run),
        }
        place.finish({**about, **report.as_json()})
    return report


def execute(
    policy: str | Policy,
    robot: Robot,
    *,
    rate: float = 25.0,
    cameras: Sequence[str] = (),
    run: RunOptions = RunOptions(),
    folder: Path | str | None = None,
    instruction: str = "",
    device: str = "cpu",
    keys: Mapping[str, str] | None = None,
    seed: int = 0,
    should_stop: Callable[[], bool] = lambda: False,
) -> EpisodeRun:
    """Execute a policy on a robot until its last step or until it is stopped.

    During the execution, the policy controls the robot's arms in place of their
    controllers.

    Args:
        policy: The policy; see ``evaluate``.
        robot: The robot that ``tool0.bringup`` or ``tool0.connect`` returned.
        rate: Actions per simulated second [Hz].
        cameras: Cameras that provide images for the policy.
        run: Options for executing the policy's actions; ``max_steps`` limits the number
            of actions.
        folder: New folder for a recording of the session, with observations and
            actions.
        instruction: Description of the task.
        device: Device on which LeRobot's policies run, such as ``cuda``.
        keys: Mapping from the names that an openpi server expects to the observed
            values.
        seed: Seed that is passed to the policy.
        should_stop: Callback that is called before each action and during waits.  If
            the callback returns True, the execution ends.

    Raises:
        ConfigError: If an argument is wrong, or the folder contains files.
        ControlError: If the robot rejects an action, in which case the arms hold their
            positions.
        PolicyError: If the policy fails, in which case the arms hold their positions.
        TransportError: If a server does not answer, in which case the arms hold their
            positions.
    """
    place = None if folder is None else _Folder(Path(folder), "none")
    environment = RobotEnvironment(
        robot,
        rate=rate,
        cameras=cameras,
        instruction=instruction,
        should_stop=should_stop,
    )
    source = opened(policy, device=device, keys=dict(keys or {}))
    with closing(source):
        if place is None:
            return run_episode(environment, source, seed, run, should_stop=should_stop)
        robot.start_recording(place.path.absolute() / "recording.mcap")
        try:
            found = run_episode(environment, source, seed, run, should_stop=should_stop)
        finally:
            robot.stop_recording()
        place.add(0, found, environment)
        about = {
            "policy": name_of(policy),
            "policy_sha256": source.digest,
            "robot": robot.description.model.name,
            "rate": rate,
            "cameras": list(cameras),
            "programs": programs(),
            **_plain(run),
        }
        place.finish(about)
        return found


def _plain(run: RunOptions) -> dict[str, Any]:
    chunks = run.chunks
    return {
        "execute": chunks.execute,
        "ensemble": chunks.ensemble,
        "compensate": chunks.compensate,
        "latency": run.latency,
        "clip": run.clips,
        "max_steps": run.max_steps,
    }


@final
class _Folder:
    """A folder with a file for each episode, a table of episodes, and the report."""

    def __init__(self, path: Path, videos: Videos) -> None:
        """Create the folder.

        Raises:
            ConfigError: If the folder contains files or cannot be created, or a
                required package is not installed.
        """
        require_extra()
        try:
            path.mkdir(parents=True, exist_ok=True)
            if any(path.iterdir()):
                raise ConfigError(f"folder {path} has files already; choose another")
            (path / "data").mkdir()
        except OSError as error:
            raise ConfigError(f"folder {path}: {error.strerror}") from None
        if videos != "none":
            from tool0.recording.video_writer import require_encoder

            require_encoder(path / "episode.mp4")
        self.path = path
        self._videos = videos

    def add(
        self,
        index: int,
        run: EpisodeRun,
        environment: TaskEnvironment | RobotEnvironment,
    ) -> None:
        """Write one episode to the folder."""
        name = f"episode_{index:06d}"
        row = {
            "episode_index": index,
            "seed": run.seed,
            "result": run.result,
            "reason": run.reason,
            "steps": run.n_steps,
            "return": run.total_reward,
            "held_steps": run.n_held,
            "latencies": [round(latency, 6) for latency in run.latencies],
        }
        if run.episode is not None:
            named = replace(
                run.episode,
                names=environment.names,
                surroundings=environment.surroundings,
            )
            _, file = encoded(named, index, "parquet")
            (self.path / "data" / f"{name}.parquet").write_bytes(file)
        has_video = self._videos == "all" or (
            self._videos == "failures" and run.result != "success"
        )
        if has_video and run.pictures:
            self._write_video(f"{name}_{run.result}.mp4", run, environment.rate)
        with (self.path / _ROWS).open("a") as stream:
            stream.write(f"{json.dumps(row)}\n")

    def finish(self, values: Mapping[str, Any]) -> None:
        """Write the report to the folder."""
        (self.path / _REPORT).write_text(f"{json.dumps(values, indent=2)}\n")

    def _write_video(self, name: str, run: EpisodeRun, rate: float) -> None:
        from tool0.recording.video_writer import VideoWriter

        folder = self.path / "videos"
        folder.mkdir(exist_ok=True)
        height, width = run.pictures[0].shape[:2]
        with VideoWriter(folder / name, width, height, rate) as video:
            for picture in run.pictures:
                video.write(picture)
