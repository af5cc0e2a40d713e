"""The recordings of one simulation, which are made one at a time."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING, final

from tool0.errors import ControlError
from tool0.protocol.recordings import RecordingStatus
from tool0.recording.options import NO_IMAGES, NO_ROTATION, Images, Rotation
from tool0.recording.recorder import Recorder

if TYPE_CHECKING:
    from tool0.simulation.simulation import Simulation


@final
class Recordings:
    """Service for recordings, returned by ``simulation.service(Recordings)``."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._lock = threading.Lock()
        self._recorder: Recorder | None = None

    @property
    def status(self) -> RecordingStatus | None:
        """The current or last recording; None before the first recording."""
        recorder = self._recorder
        return None if recorder is None else recorder.status

    def start(
        self,
        path: Path,
        rotation: Rotation = NO_ROTATION,
        images: Images = NO_IMAGES,
        *,
        overwrite: bool = False,
    ) -> RecordingStatus:
        """Start a recording.

        Raises:
            ControlError: If a recording is already in progress.
            RecordingError: If the file cannot be written.
            RenderError: If a camera does not exist, or its images cannot be rendered.
        """
        with self._lock:
            status = self.status
            if status is not None and status.is_recording:
                raise ControlError(
                    f"a recording to {status.file} is in progress; stop it first"
                )
            self._recorder = Recorder(
                self._simulation, path, rotation, images, overwrite=overwrite
            )
            return self._recorder.status

    def stop(self) -> RecordingStatus:
        """End the recording, and return its last status.

        Raises:
            ControlError: If no recording is in progress.
        """
        with self._lock:
            if self._recorder is None:
                raise ControlError("nothing is recorded; start a recording first")
            return self._recorder.stop()

    def close(self) -> None:
        """End the current recording, if there is one, and complete its file."""
        with self._lock:
            if self._recorder is not None:
                self._recorder.stop()
