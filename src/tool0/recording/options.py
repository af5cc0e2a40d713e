"""What can be chosen of a recording, and what is known of it."""

from __future__ import annotations

from typing import Final, final

from msgspec import Struct


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
    """Of all its files [bytes]."""
    files: int = 1
    """How many there are: the recording rotates."""
    dropped: int = 0
    """Snapshots that are missing, because the disk was too slow."""
    error: str | None = None
    """Why it ended by itself, such as a full disk."""


@final
class Rotation(Struct, frozen=True, kw_only=True):
    """When a recording goes on in another file."""

    max_size: int | None = None
    """[bytes]"""
    max_duration: float | None = None
    """Simulated time [s]."""
    max_files: int | None = None
    """Files that are kept; the oldest are deleted."""


@final
class Images(Struct, frozen=True, kw_only=True):
    """Which images are recorded."""

    cameras: tuple[str, ...] = ()
    """Names of cameras."""
    rate: float = 5.0
    """Images of each per simulated second [Hz]."""


NO_ROTATION: Final = Rotation()
NO_IMAGES: Final = Images()
