"""What can be chosen of a recording, and what is known of it."""

from __future__ import annotations

from typing import Final, final

from msgspec import Struct


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
