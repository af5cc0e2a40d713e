"""Requests about the recording of a running robot."""

from __future__ import annotations

from typing import Annotated, final

from msgspec import Meta, Struct

from tool0.protocol.request import Name, Request


@final
class RecordingStatus(Struct, frozen=True, kw_only=True):
    """State of the recording in progress, or of the last recording."""

    file: str
    """Path of the newest file of the recording."""
    is_recording: bool
    """Whether the recording is still in progress."""
    duration: float
    """Simulated time that was recorded in all files [s]."""
    size: int
    """Total size of the recording's files [bytes]."""
    files: int = 1
    """Number of files that the recording has started, including deleted files."""
    dropped: int = 0
    """Number of snapshots that were dropped because the disk was too slow."""
    error: str | None = None
    """Error that ended the recording early, such as a full disk; null without an
    error."""


class StartRecording(Request[RecordingStatus], frozen=True):
    """Record to an MCAP file until ``stop_recording`` or until the robot is closed."""

    written_paths = ("file",)

    file: Annotated[str, Meta(min_length=1, max_length=4000)] | None = None
    """Path on the simulation's machine: a file with the suffix ``.mcap``, or a folder.
    In a folder, the file name consists of the date and the time.  The default is the
    user's folder of recordings."""
    overwrite: bool = False
    """Whether to replace an existing file."""
    max_size: Annotated[int, Meta(ge=1_000_000, le=1 << 40)] | None = None
    """File size at which a new file is started [bytes]."""
    max_duration: Annotated[float, Meta(ge=1.0, le=1e6)] | None = None
    """Simulated time after which a new file is started [s]."""
    max_files: Annotated[int, Meta(ge=1, le=100_000)] | None = None
    """Number of files to keep; older files are deleted."""
    cameras: Annotated[tuple[Name, ...], Meta(max_length=16)] = ()
    """Cameras whose images are recorded."""
    camera_rate: Annotated[float, Meta(ge=0.1, le=60.0)] = 5.0
    """Image rate of each camera in simulated time [Hz]."""


class StopRecording(Request[RecordingStatus], frozen=True):
    """End the recording, and complete the file."""


class ReadRecording(Request[RecordingStatus | None], frozen=True):
    """Read the state of the recording in progress, or of the last recording."""
