"""Requests about the recording of a running robot."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

from msgspec import Meta

from tool0.errors import RecordingError
from tool0.recording.options import Images, RecordingStatus, Rotation
from tool0.recording.recordings import Recordings
from tool0.requests.table import Name, Request, handles
from tool0.runtime.simulation import Simulation
from tool0.user_data import data_folder

SUFFIX = ".mcap"


class StartRecording(Request[RecordingStatus], frozen=True):
    """Record to an MCAP file until ``stop_recording``, or until the robot is closed."""

    file: Annotated[str, Meta(min_length=1, max_length=4000)] | None = None
    """The path on the simulation's machine, which ends in ``.mcap``, or a folder for a
    file named by date and time; if left out, the user's folder of recordings."""
    overwrite: bool = False
    """Whether to replace a file that exists."""
    max_size: Annotated[int, Meta(ge=1_000_000, le=1 << 40)] | None = None
    """Go on in another file from this size on [bytes]."""
    max_duration: Annotated[float, Meta(ge=1.0, le=1e6)] | None = None
    """Go on in another file after this simulated time [s]."""
    max_files: Annotated[int, Meta(ge=1, le=100_000)] | None = None
    """Keep only so many files, the newest."""
    cameras: Annotated[tuple[Name, ...], Meta(max_length=16)] = ()
    """Cameras whose images are recorded."""
    camera_rate: Annotated[float, Meta(ge=0.1, le=60.0)] = 5.0
    """Images of each per simulated second [Hz]."""


class StopRecording(Request[RecordingStatus], frozen=True):
    """End the recording, and complete its file."""


class ReadRecording(Request[RecordingStatus | None], frozen=True):
    """The recording in progress, or the last one."""


@handles(StartRecording)
def _start(simulation: Simulation, request: StartRecording) -> RecordingStatus:
    rotation = Rotation(
        max_size=request.max_size,
        max_duration=request.max_duration,
        max_files=request.max_files,
    )
    path = checked_file(None if request.file is None else Path(request.file))
    recordings = simulation.service(Recordings)
    images = Images(cameras=request.cameras, rate=request.camera_rate)
    return recordings.start(path, rotation, images, overwrite=request.overwrite)


handles(StopRecording)(lambda sim, _: sim.service(Recordings).stop())
handles(ReadRecording)(lambda sim, _: sim.service(Recordings).status)


def checked_file(path: Path | None) -> Path:
    """Return where a recording is to be written.

    Raises:
        RecordingError: If the name does not end in ``.mcap``.
    """
    if path is None:
        folder = data_folder() / "recordings"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RecordingError(f"cannot make {folder}: {error.strerror}") from error
        return _new_file(folder)
    path = path.expanduser().absolute()
    if path.is_dir():
        return _new_file(path)
    if path.suffix != SUFFIX:
        raise RecordingError(
            f"a recording's name ends in {SUFFIX}, got '{path.name}'; "
            f"write '{path.with_suffix(SUFFIX).name}'"
        )
    return path


def _new_file(folder: Path) -> Path:
    name = time.strftime("%Y-%m-%d_%H-%M-%S")
    path, number = folder / f"{name}{SUFFIX}", 1
    while path.exists():
        number += 1
        path = folder / f"{name}_{number}{SUFFIX}"
    return path
