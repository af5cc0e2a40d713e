"""Recording thread, which writes the snapshots of a subscription to a file."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.errors import Tool0Error
from tool0.protocol.bus import Reported, WasReset
from tool0.protocol.recordings import RecordingStatus
from tool0.protocol.state import SNAPSHOT_PERIOD, Snapshot, ticks_between_snapshots
from tool0.recording.contents import Contents
from tool0.recording.events import EventQueue
from tool0.recording.options import NO_IMAGES, NO_ROTATION, Images, Rotation
from tool0.recording.part import Part

if TYPE_CHECKING:
    from tool0.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

FLUSH_PERIOD: Final = 0.4
"""Wall time between chunks [s].  If the process is killed, at most 0.4 s of data is
lost."""
FORCES_PERIOD: Final = 0.032
"""Simulated time between two samples of contacts and wrenches [s].  The engine computes
contacts and wrenches only on request."""
_POLL_PERIOD: Final = 0.04
"""Wall time between polls for snapshots [s].  Each poll is short, so the tick does not
wait for the interpreter's lock."""
_MOST_WAITING: Final = 2500
"""Largest number of snapshots that are buffered before they are written (20 s).  If the
buffer is full, a real-time recording drops the oldest snapshots, and any other
recording pauses simulated time."""


@final
class Recorder:
    """One recording, from its start to ``stop`` or an error."""

    def __init__(
        self,
        simulation: Simulation,
        path: Path,
        rotation: Rotation = NO_ROTATION,
        images: Images = NO_IMAGES,
        *,
        overwrite: bool = False,
    ) -> None:
        """Create the file and start the recording thread.

        Raises:
            RecordingError: If the file cannot be written.
            RenderError: If a camera does not exist, or images cannot be rendered.
        """
        for name in images.cameras:  # fails before the recording starts
            simulation.cameras.render(simulation.cameras[name])
        self._images = images
        self._simulation = simulation
        self._path, self._rotation, self._overwrite = path, rotation, overwrite
        period = simulation.loop.control_period
        self._ticks = ticks_between_snapshots(SNAPSHOT_PERIOD, period)
        self._contents = Contents(simulation)
        self._files: deque[Path] = deque()
        self._n_parts = 0
        self._size_before = 0
        """Size of the completed files [bytes]."""
        self._duration_before = 0.0
        """Duration of the completed files [s]."""
        self._dropped = 0
        self._error: str | None = None
        self._seen: Snapshot | None = None
        self._is_over = threading.Event()
        self._part = self._new_part()
        self._backlog: deque[Snapshot] = deque()
        is_realtime = simulation.loop.is_realtime
        self._subscription = simulation.subscribe(
            1.0 / SNAPSHOT_PERIOD,
            keep_all=True,
            most_kept=_MOST_WAITING if is_realtime else None,
            with_arms=True,
            with_contacts=True,
            # The sampling of the arms marks the snapshots that have forces.
            forces_period=FORCES_PERIOD if simulation.arms else 0.0,
            when_published=None if is_realtime else self._hold_time,
        )
        backlog = self._subscription.backlog
        assert backlog is not None  # this subscription keeps all snapshots
        self._backlog = backlog
        self._events = EventQueue(self._subscription)
        # This call makes the loop publish the first snapshot of the file.
        simulation.loop.call(lambda: None)
        self._next_flush = 0.0
        self._thread = threading.Thread(
            target=self._run, name="tool0 recorder", daemon=True
        )
        self._thread.start()

    @property
    def status(self) -> RecordingStatus:
        part = self._part
        return RecordingStatus(
            file=str(part.path),
            is_recording=not self._is_over.is_set(),
            duration=self._duration_before + part.duration,
            size=self._size_before + part.size,
            files=self._n_parts,
            dropped=self._dropped,
            error=self._error,
        )

    def stop(self) -> RecordingStatus:
        """Write the remaining data and close the file.

        The recording may have ended already.
        """
        self._is_over.set()
        self._thread.join()
        return self.status

    # ---- tick thread -----------------------------------------------------------------

    def _hold_time(self) -> None:
        """Wait until the backlog is shorter; only real-time recordings drop data."""
        backlog = self._backlog
        while len(backlog) >= _MOST_WAITING and not self._is_over.is_set():
            time.sleep(_POLL_PERIOD)

    # ---- recorder thread -------------------------------------------------------------

    def _run(self) -> None:
        try:
            while not self._is_over.wait(_POLL_PERIOD):
                self._take()
            self._take()
            if self._seen is not None:
                for event in self._events.rest():
                    self._part.write_event(event, self._seen.time)
            self._part.finish()
        except Exception as error:  # the simulation must continue
            self._fail(error)
        finally:
            if not self._simulation.loop.is_closed:
                self._subscription.close()

    def _take(self) -> None:
        snapshots = self._subscription.pending()
        self._part.write_requests()  # before the resulting snapshots
        for snapshot in snapshots:
            self._take_one(snapshot)
            time.sleep(0.0)  # gives other threads the interpreter
        now = time.monotonic()
        if now >= self._next_flush:
            self._next_flush = now + FLUSH_PERIOD
            self._part.flush()

    def _take_one(self, snapshot: Snapshot) -> None:
        seen = self._seen
        has_restarted = seen is not None and snapshot.time < seen.time
        for event in self._events.before(snapshot, seen):
            if has_restarted and isinstance(event, WasReset):
                self._rotate()
                has_restarted = False
            self._part.write_event(event, snapshot.time)
        if seen is not None:
            self._part.write_changes(seen, snapshot)
        self._seen = snapshot
        if not self._is_wanted(snapshot):
            return
        if has_restarted or self._is_full():
            self._rotate()
        last = self._part.last
        if last is not None:
            steps = snapshot.tick // self._ticks - last.tick // self._ticks
            self._dropped += max(0, steps - 1)
        self._part.write(snapshot)

    def _is_full(self) -> bool:
        part, rotation = self._part, self._rotation
        size, duration = rotation.max_size, rotation.max_duration
        return (size is not None and part.size >= size) or (
            duration is not None and part.duration >= duration
        )

    def _is_wanted(self, snapshot: Snapshot) -> bool:
        """Return whether a snapshot is due, or contains changes that must be written.

        Additional snapshots are published after requests and for faster subscribers.
        """
        last = self._part.last
        if last is None or snapshot.time < last.time:
            return True
        if snapshot.tick == last.tick and snapshot.time == last.time:
            return snapshot.is_paused and (
                snapshot.position != last.position
                or snapshot.scene is not last.scene
                or snapshot.objects != last.objects
            )
        return snapshot.tick % self._ticks == 0 or snapshot.is_paused

    def _rotate(self) -> None:
        """Continue the recording in a new file."""
        old, self._part = self._part, self._new_part()
        old.finish()
        self._size_before += old.size
        self._duration_before += old.duration
        most = self._rotation.max_files
        while most is not None and len(self._files) > most:
            self._files.popleft().unlink(missing_ok=True)

    def _new_part(self) -> Part:
        self._n_parts += 1
        path, number = self._path, self._n_parts
        if number > 1:
            path = path.with_stem(f"{path.stem}_{number}")
        part = Part(
            self._simulation,
            self._contents,
            path,
            images=self._images,
            number=number,
            first=self._path,
            overwrite=self._overwrite,
        )
        self._files.append(path)
        return part

    def _fail(self, error: Exception) -> None:
        """After an error, end the recording without stopping the simulation."""
        if isinstance(error, OSError):
            reason = f"{self._part.path}: {error.strerror}"
        elif isinstance(error, Tool0Error):
            reason = str(error)
        else:
            logger.exception("the recorder failed")
            reason = f"{self._part.path}: {error!r}"
        self._error = reason
        logger.warning("the recording has ended: %s", reason)
        text = f"the recording has ended: {reason}"
        try:
            self._part.abandon()
            self._simulation.bus.announce(
                Reported(text, self._simulation.snapshot.time)
            )
        finally:  # set last, when the recording has ended completely
            self._is_over.set()
