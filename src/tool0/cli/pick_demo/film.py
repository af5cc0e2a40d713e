"""A demo as a film: snapshots are kept while it runs, and drawn afterwards."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, final

from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

RATE = 30
"""Frames per simulated second [Hz]."""
_ROUNDING = 1e-9  # [s]


@final
class Film:
    """The snapshots of a demo that become frames.

    Drawing takes longer than simulating, so that it waits: the demo runs as it would
    without.
    """

    def __init__(self, rate: int = RATE) -> None:
        """Take ``rate`` frames a simulated second [Hz]."""
        self._rate = rate
        self._due: float | None = None  # simulated time of the next frame [s]
        self.frames: list[Snapshot] = []
        """What was kept, in order."""

    def take(self, snapshot: Snapshot) -> None:
        """Keep a snapshot if the next frame is due."""
        period = 1.0 / self._rate
        due = snapshot.time if self._due is None else self._due
        if abs(snapshot.time - due) > period + _ROUNDING:
            due = snapshot.time  # after a reset, or a time that nobody watched: a cut
        if snapshot.time >= due - _ROUNDING:
            self.frames.append(snapshot)
            due += period
        self._due = due

    def write(
        self,
        path: Path,
        robot: Robot,
        camera: str,
        progress: Callable[[str, float], None],
    ) -> None:
        """Draw what was kept as ``camera`` sees it, into an MP4.

        Args:
            path: The file, which is replaced.
            robot: Whose film it is.
            camera: One of its cameras.
            progress: Called with what is done and the part of it that is.

        Raises:
            ConfigError: If the file cannot be written.
            RenderError: If nothing can draw or encode here.
        """
        from tool0.sensing.video import VideoWriter

        view = robot.camera(camera)
        size = view.camera
        activity = f"writing {path.name}"
        with VideoWriter(path, size.width, size.height, self._rate) as video:
            for number, snapshot in enumerate(self.frames):
                progress(activity, number / len(self.frames))
                video.write(view.image(snapshot).rgb)
        progress(activity, 1.0)
