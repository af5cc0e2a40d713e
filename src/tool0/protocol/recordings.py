"""Requests about the recording of a running robot."""

from __future__ import annotations

from typing import Annotated, final

from msgspec import Meta, Struct

from tool0.protocol.request import Name, Request


@final
class RecordingStatus(Struct, frozen=True, kw_only=True):
    """The recording in progress, or the last one."""

    file: str
    """The file that is written; the last one, after a rotation."""
    is_recording: bool
    """Whether snapshots are still written."""
    duration: float
    """Simulated time recorded, in all files [s]."""
    size: int
    """Size of all its files [bytes]."""
    files: int = 1
    """Number of files, if the recording rotates."""
    dropped: int = 0
    """Snapshots that are missing, because the disk was too slow."""
    error: str | None = None
    """Error that ended it early, such as a full disk."""


class StartRecording(Request[RecordingStatus], frozen=True):
    """Record to an MCAP file until ``stop_recording``, or until the robot is closed."""

    written_paths = ("file",)

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
