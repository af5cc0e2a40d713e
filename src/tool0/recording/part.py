"""One self-contained file of a recording; each rotation begins a new one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, final

from tool0.errors import RecordingError
from tool0.recording.contents import Contents
from tool0.recording.events import ContactWatch, EventWriter
from tool0.recording.frames import FrameWriter
from tool0.recording.images import ImageWriter
from tool0.recording.journal import RequestWriter
from tool0.recording.mcap_file import McapFile

if TYPE_CHECKING:
    from tool0.protocol.bus import Event
    from tool0.protocol.state import Snapshot
    from tool0.recording.options import Images
    from tool0.simulation.simulation import Simulation


@final
class Part:
    """Writer of a file with the robot, all earlier requests and later snapshots."""

    def __init__(
        self,
        simulation: Simulation,
        contents: Contents,
        path: Path,
        *,
        images: Images,
        number: int,
        first: Path,
        overwrite: bool,
    ) -> None:
        """Create file ``number`` of the recording that begins with the file ``first``.

        Raises:
            RecordingError: If the file cannot be written.
        """
        model = simulation.description.model
        self._file = McapFile(path, overwrite=overwrite)
        try:
            contents.write(self._file, number, first)
        except OSError as error:
            self._file.abandon()
            raise RecordingError(f"cannot write {path}: {error.strerror}") from error
        self._cameras = simulation.cameras
        self._urdf = simulation.description.urdf
        self._frames = FrameWriter(self._file, model, contents.joint_names)
        self._images = ImageWriter(
            self._file, simulation.cameras, images.cameras, 1.0 / images.rate
        )
        self._events = EventWriter(self._file)
        self._touches = ContactWatch(model)
        self._requests = RequestWriter(self._file, simulation.journal)
        self.start: float | None = None
        """Simulated time of the first snapshot [s]."""
        self.last: Snapshot | None = None

    @property
    def path(self) -> Path:
        return self._file.path

    @property
    def size(self) -> int:
        """Number of bytes that have been written."""
        return self._file.size

    @property
    def duration(self) -> float:
        """Simulated time from the first snapshot to the last snapshot [s]."""
        if self.start is None or self.last is None:
            return 0.0
        return self.last.time - self.start

    def write(self, snapshot: Snapshot) -> None:
        """Add a snapshot to the file."""
        if self.start is None:
            self.start = snapshot.time
            self._frames.write_robot(self._urdf, self._cameras, snapshot.time)
        self._frames.write(snapshot)
        self._images.write(snapshot)
        for contact in self._touches.begun(snapshot):
            self._events.write_contact(contact, snapshot.time)
        self.last = snapshot

    def write_event(self, event: Event, now: float) -> None:
        """Add an event from the bus; ``now`` [s] is used for events without a time."""
        self._events.write_event(event, now)

    def write_changes(self, before: Snapshot, snapshot: Snapshot) -> None:
        """Add the events that result from the differences between two snapshots."""
        self._events.write_changes(before, snapshot)

    def write_requests(self) -> None:
        """Add the requests since the last call.

        The first call adds all requests since the bring-up.
        """
        self._requests.write_new()

    def flush(self) -> None:
        """Pass all data to the operating system, where it survives a process crash."""
        self._file.flush()

    def finish(self) -> None:
        """Complete the file."""
        self._requests.write_new()
        self._file.finish()

    def abandon(self) -> None:
        """Close the file after an error."""
        self._file.abandon()
