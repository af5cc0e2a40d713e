"""Demonstrations as a data set: recordings of episodes, in LeRobot's format.

The state is the position of each driven joint, then its velocity.  The action is the
position that is commanded at the next frame; joints of a stream have no recorded
setpoint, and theirs is where they are then.  Images are rendered from the snapshots.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tool0.collect import parquet
from tool0.collect.dataset import Manifest, opened
from tool0.collect.rollout import Array, Episode
from tool0.collect.settings import Settings, require_extra
from tool0.errors import CollectError, ConfigError
from tool0.recording.episodes import EpisodeRow, read_index
from tool0.recording.reading import RecordingFile, open_recording
from tool0.recording.video import cameras_of


def export_lerobot(
    folder: Path,
    target: Path,
    *,
    rate: float = 25.0,
    only_successes: bool = False,
    cameras: Sequence[str] = (),
    width: int | None = None,
    height: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Manifest:
    """Write the episodes of a folder as a LeRobot data set of version 2.1.

    Args:
        folder: What ``tool0 record --episodes`` made.
        target: A new folder.
        rate: Frames per simulated second [Hz], a divisor of the recordings' rate.
        only_successes: Leave out the episodes that failed.
        cameras: Cameras of the robot or its scene whose images each frame has.
        width: Of these [pixels]; the camera's own, if left out.
        height: Likewise.
        progress: Called with the episodes done and their total.

    Raises:
        RecordingError: If the folder has no index, or a file is damaged.
        ConfigError: If the target has other files, the rate does not fit, or the extra
            ``collect`` is not installed.
        CollectError: If there are no episodes, or they have different tasks or joints.
        RenderError: If there is no OpenGL, or no such camera.
    """
    require_extra()
    rows = [
        row
        for row in read_index(folder)
        if row.outcome == "success" or not only_successes
    ]
    tasks = {row.task for row in rows}
    if not rows:
        raise CollectError(f"{folder} has no episodes to export")
    if len(tasks) > 1:
        raise CollectError(
            f"{folder} has episodes of several tasks ({', '.join(sorted(tasks))}); "
            "record each task into a folder of its own"
        )
    settings = Settings(
        task=tasks.pop() or folder.name,
        options={
            "rate": rate,
            "only_successes": only_successes,
            "cameras": list(cameras),
            "width": width,
            "height": height,
        },
        seed=0,
        policy="demonstrations",
        digest=None,
        format="lerobot",
    )
    joints: tuple[str, ...] | None = None
    with opened(target, settings, len(rows)) as dataset:
        if dataset.manifest.n_episodes:
            raise ConfigError(f"{target} has episodes already; choose another folder")
        for index, row in enumerate(rows):
            recording = open_recording(folder / row.file)
            driven = driven_joints(recording)
            if joints not in (None, driven):
                raise CollectError(f"{row.file} is of another robot than the first")
            joints = driven
            episode = episode_of(
                recording, row, rate, cameras=cameras, width=width, height=height
            )
            dataset.add([parquet.encoded(episode, index, "lerobot")])
            progress(index + 1, len(rows))
        return dataset.manifest


def driven_joints(recording: RecordingFile) -> tuple[str, ...]:
    """Return the joints that have a motor, in the order of the recording."""
    driven = {item.joint for item in recording.description.model.transmissions}
    return tuple(name for name in recording.joint_names if name in driven)


def episode_of(
    recording: RecordingFile,
    row: EpisodeRow,
    rate: float,
    *,
    cameras: Sequence[str] = (),
    width: int | None = None,
    height: int | None = None,
) -> Episode:
    """Return one episode with ``rate`` frames per simulated second [Hz].

    Raises:
        ConfigError: If the recording does not have whole frames at that rate.
        CollectError: If it is too short.
        RenderError: If there is no OpenGL, or no such camera.
    """
    period = recording.info.control_period
    ticks = round(1.0 / (rate * period))
    if not ticks or not np.isclose(ticks * period * rate, 1.0, rtol=1e-9):
        raise ConfigError(
            f"rate {rate:g} Hz: a frame is no whole number of control periods of "
            f"{period:g} s"
        )
    frames = _frames_every(recording, ticks)
    if len(frames) < 2:
        raise CollectError(
            f"{row.file} has no two frames {1.0 / rate:g} s apart: it is too short, or "
            f"was not recorded at a multiple of {rate:g} Hz"
        )
    joints = driven_joints(recording)
    columns = [recording.joint_names.index(name) for name in joints]
    position = recording.position[:, columns][frames]
    velocity = recording.velocity[:, columns][frames]
    commanded = recording.desired_position[:, columns][frames]
    actions = np.where(np.isnan(commanded[1:]), position[1:], commanded[1:])
    n = len(actions)
    success = row.outcome == "success"
    rewards = np.zeros(n)
    rewards[-1] = float(success)
    return Episode(
        seed=row.episode,
        observations={
            "position": position[:n],
            "velocity": velocity[:n],
            **_images(recording, frames[:n], cameras, width, height),
        },
        actions=actions,
        rewards=rewards,
        terminated=True,
        success=success,
        rate=rate,
        names={
            "position": [f"{name}.position" for name in joints],
            "velocity": [f"{name}.velocity" for name in joints],
            "action": [f"{name}.position" for name in joints],
        },
    )


def _images(
    recording: RecordingFile,
    frames: Array,
    names: Sequence[str],
    width: int | None,
    height: int | None,
) -> dict[str, Array]:
    """Return the images of each camera, shape (n_frames, height, width, 3), uint8."""
    if not names:
        return {}
    cameras, snapshots = cameras_of(recording), recording.snapshots()
    try:
        found: dict[str, Array] = {}
        for name in names:
            own = cameras[name]
            sized = replace(own, width=width or own.width, height=height or own.height)
            found[name] = np.stack(
                [cameras.render(sized, snapshots[frame]).rgb for frame in frames]
            )
        return found
    finally:
        cameras.close()


def _frames_every(recording: RecordingFile, ticks: int) -> Array:
    """Return the frames at multiples of ``ticks``, up to the first that is missing.

    The very first snapshot is often between those that come at a regular rate.
    """
    tick = recording.tick
    found = np.flatnonzero(tick % ticks == 0)
    _, first = np.unique(tick[found], return_index=True)
    chosen = found[first]
    gaps = np.flatnonzero(np.diff(tick[chosen]) != ticks)
    return chosen[: gaps[0] + 1] if len(gaps) else chosen
