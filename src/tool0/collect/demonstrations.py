"""Conversion of recorded demonstrations to a LeRobot data set.

The state consists of the positions of the driven joints, followed by their velocities.
The action is the position that is commanded at the next frame.  No setpoint is recorded
for joints that follow a stream, so their action is the measured position at the next
frame.  The poses of objects form the environment state.  Images are rendered from the
snapshots.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from tool0.collect.dataset import Manifest, opened
from tool0.collect.encoding import encoded
from tool0.collect.lerobot import whole_rate
from tool0.collect.parquet import Array
from tool0.collect.resampling import Resampled
from tool0.collect.rollout import Episode
from tool0.collect.settings import Settings, require_extra
from tool0.description.model import RobotModel
from tool0.errors import CollectError, ConfigError
from tool0.recording.episodes import EpisodeRow, read_index
from tool0.recording.reading import RecordingFile, open_recording
from tool0.recording.video import cameras_of

OBJECT: Final = "object."
"""Prefix of an object's name in the name of its observation."""
_POSE: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")


def export_lerobot(
    folder: Path,
    target: Path,
    *,
    rate: float = 25.0,
    only_successes: bool = False,
    instruction: str | None = None,
    cameras: Sequence[str] = (),
    width: int | None = None,
    height: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Manifest:
    """Write the episodes of a folder as a LeRobot data set in version 3.0.

    Args:
        folder: Folder that ``tool0 record --episodes`` has written.
        target: A new folder for the data set.
        rate: Frames per simulated second [Hz].  The rate must be a whole number that
            does not exceed the recordings' rate.
        only_successes: Whether to leave out episodes that failed.
        instruction: Description of the task; the default is the description that was
            given when the episodes were recorded.
        cameras: Cameras of the robot or the scene that provide images for each frame.
        width: Width of the images [pixels] (default: the width of the camera).
        height: Height of the images [pixels] (default: the height of the camera).
        progress: Callback that is called with the number of finished episodes and the
            total number of episodes.

    Raises:
        RecordingError: If the folder has no index, or a file is damaged.
        ConfigError: If the target contains other files, the rate is out of range, or
            the extra ``collect`` is not installed.
        CollectError: If there are no episodes, or they have different tasks or joints.
        RenderError: If OpenGL is not available, or there is no such camera.
    """
    require_extra()
    whole_rate(rate)
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
    task = tasks.pop() or folder.resolve().name
    settings = Settings(
        task=task,
        task_digest=None,
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
        instruction=task if instruction is None else instruction,
    )
    joints: tuple[str, ...] | None = None
    objects = _common_objects(folder, rows)
    with opened(target, settings, len(rows)) as dataset:
        if dataset.manifest.n_episodes:
            raise ConfigError(f"{target} has episodes already; choose another folder")
        for index, row in enumerate(rows):
            recording = open_recording(folder / row.file)
            driven = driven_joints(recording.description.model, recording.joint_names)
            if joints not in (None, driven):
                raise CollectError(f"{row.file} is of another robot than the first")
            joints = driven
            episode = episode_of(
                recording,
                row,
                rate,
                objects=objects,
                cameras=cameras,
                width=width,
                height=height,
            )
            dataset.add([encoded(episode, index, "lerobot")])
            progress(index + 1, len(rows))
        return dataset.manifest


def driven_joints(model: RobotModel, names: Sequence[str]) -> tuple[str, ...]:
    """Return the joints in ``names`` that have a motor, in the same order."""
    driven = {item.joint for item in model.transmissions}
    return tuple(name for name in names if name in driven)


def number_names(
    joints: Sequence[str], objects: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Return the component names of a robot's observations and of its action.

    ``position``, ``velocity`` and ``action`` have one component per driven joint;
    ``object.NAME`` consists of a position and a quaternion.
    """
    positions = tuple(f"{name}.position" for name in joints)
    return {
        "position": positions,
        "velocity": tuple(f"{name}.velocity" for name in joints),
        "action": positions,
        **{
            f"{OBJECT}{name}": tuple(f"{name}.{part}" for part in _POSE)
            for name in objects
        },
    }


def surroundings_of(names: Mapping[str, Sequence[str]]) -> frozenset[str]:
    """Return the names of the components that describe objects."""
    return frozenset(
        each for key, named in names.items() if key.startswith(OBJECT) for each in named
    )


def _common_objects(folder: Path, rows: Sequence[EpisodeRow]) -> tuple[str, ...]:
    """Return the objects that exist in every snapshot of every episode."""
    common: dict[str, None] | None = None
    for row in rows:
        poses = open_recording(folder / row.file).objects
        there = [name for name, pose in poses.items() if not np.isnan(pose).any()]
        common = dict.fromkeys(n for n in there if common is None or n in common)
    return tuple(common or ())


def episode_of(
    recording: RecordingFile,
    row: EpisodeRow,
    rate: float,
    *,
    objects: Sequence[str] = (),
    cameras: Sequence[str] = (),
    width: int | None = None,
    height: int | None = None,
) -> Episode:
    """Return one episode, resampled to ``rate`` frames per simulated second.

    Numbers are interpolated between two snapshots; images show the nearest snapshot.

    Raises:
        ConfigError: If the recording has fewer than ``rate`` snapshots per second.
        CollectError: If the episode is too short.
        RenderError: If OpenGL is not available, or there is no such camera.
    """
    frames = Resampled(recording.tick, recording.info.control_period, rate, row.file)
    joints = driven_joints(recording.description.model, recording.joint_names)
    columns = [recording.joint_names.index(name) for name in joints]
    position = frames.between(recording.position[:, columns])
    velocity = frames.between(recording.velocity[:, columns])
    commanded = frames.between(recording.desired_position[:, columns])
    actions = np.where(np.isnan(commanded[1:]), position[1:], commanded[1:])
    n = len(actions)
    success = row.outcome == "success"
    rewards = np.zeros(n)
    rewards[-1] = float(success)
    poses = {f"{OBJECT}{name}": recording.objects[name] for name in objects}
    names = number_names(joints, objects)
    return Episode(
        seed=row.episode,
        observations={
            "position": position[:n],
            "velocity": velocity[:n],
            **{key: frames.poses_between(pose)[:n] for key, pose in poses.items()},
            **_images(recording, frames.nearest[:n], cameras, width, height),
        },
        actions=actions,
        rewards=rewards,
        terminated=True,
        success=success,
        rate=rate,
        names=names,
        surroundings=surroundings_of(names),
    )


def _images(
    recording: RecordingFile,
    frames: Array,
    names: Sequence[str],
    width: int | None,
    height: int | None,
) -> dict[str, Array]:
    """Return each camera's images, uint8, shape (n_frames, height, width, 3)."""
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
