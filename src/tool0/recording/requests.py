"""Requests for recordings of a running robot."""

from __future__ import annotations

import time
from pathlib import Path

from tool0.errors import ConfigError, RecordingError
from tool0.protocol.recordings import (
    ReadRecording,
    RecordingStatus,
    StartRecording,
    StopRecording,
)
from tool0.recording.options import Images, Rotation, recordings_folder
from tool0.recording.recordings import Recordings
from tool0.simulation.handlers.table import handles
from tool0.simulation.simulation import Simulation
from tool0.user_data import expanded

SUFFIX = ".mcap"


@handles(StartRecording)
def _start(simulation: Simulation, request: StartRecording) -> RecordingStatus:
    rotation = Rotation(
        max_size=request.max_size,
        max_duration=request.max_duration,
        max_files=request.max_files,
    )
    path = checked_file(request.file)
    recordings = simulation.service(Recordings)
    images = Images(cameras=request.cameras, rate=request.camera_rate)
    return recordings.start(path, rotation, images, overwrite=request.overwrite)


handles(StopRecording)(lambda sim, _: sim.service(Recordings).stop())
handles(ReadRecording)(lambda sim, _: sim.service(Recordings).status)


def checked_file(file: Path | str | None) -> Path:
    """Return the path of the file to which a recording will be written.

    Raises:
        RecordingError: If the name does not end in ``.mcap`` or is not a valid path.
    """
    if file is None:
        folder = recordings_folder()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RecordingError(f"cannot make {folder}: {error.strerror}") from error
        return _new_file(folder)
    path = given_path(file)
    if path.is_dir():
        return _new_file(path)
    if path.suffix != SUFFIX:
        raise RecordingError(
            f"a recording's name ends in {SUFFIX}, got '{path.name}'; "
            f"write '{path.with_suffix(SUFFIX).name}'"
        )
    return path


def given_path(path: Path | str) -> Path:
    """Return the absolute path of a file or folder that may not exist.

    Raises:
        RecordingError: If the name is not a valid path.
    """
    try:
        whole = expanded(path).absolute()
        whole.lstat()
    except FileNotFoundError:
        return whole
    except (ConfigError, OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise RecordingError(f"cannot use {str(path)!r}: {reason}") from None
    return whole


def _new_file(folder: Path) -> Path:
    name = time.strftime("%Y-%m-%d_%H-%M-%S")
    path, number = folder / f"{name}{SUFFIX}", 1
    while path.exists():
        number += 1
        path = folder / f"{name}_{number}{SUFFIX}"
    return path
