"""Options of a recording, and default folders."""

from __future__ import annotations

from pathlib import Path
from typing import Final, final

from msgspec import Struct

from tool0.user_data import data_folder


@final
class Rotation(Struct, frozen=True, kw_only=True):
    """Conditions for splitting a recording into files."""

    max_size: int | None = None
    """Largest size of a file [bytes]."""
    max_duration: float | None = None
    """Largest duration of a file in simulated time [s]."""
    max_files: int | None = None
    """Number of files that are kept; older files are deleted."""


@final
class Images(Struct, frozen=True, kw_only=True):
    """Selection of images to record."""

    cameras: tuple[str, ...] = ()
    """Names of the cameras."""
    rate: float = 5.0
    """Images per camera and simulated second [Hz]."""


NO_ROTATION: Final = Rotation()
NO_IMAGES: Final = Images()


def recordings_folder() -> Path:
    """Return the default folder of recordings, which may not exist yet."""
    return data_folder() / "recordings"


def episodes_folder() -> Path:
    """Return the folder in which web pages may open folders of episodes."""
    return data_folder() / "episodes"
