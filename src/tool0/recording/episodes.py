"""Demonstrations: a folder with one recording per episode, and an index.

A user or a program moves the robot, starts each episode and specifies its outcome by
pressing a key in the terminal or the panel, or by sending a request.
``episodes.jsonl`` has a line for each episode that was kept, in the order of the
episode numbers.
"""

from __future__ import annotations

import json
import os
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

import msgspec
from msgspec import Struct

from tool0.errors import ControlError, RecordingError
from tool0.protocol.episodes import (
    CloseEpisodes,
    EndEpisode,
    EpisodeEnd,
    EpisodesStatus,
    OpenEpisodes,
    Outcome,
    ReadEpisodes,
    StartEpisode,
)
from tool0.protocol.running import Reset
from tool0.recording.recordings import Recordings
from tool0.recording.requests import given_path
from tool0.simulation.handlers.table import answer, handles

if TYPE_CHECKING:
    from tool0.protocol.recordings import RecordingStatus
    from tool0.simulation.simulation import Simulation

INDEX: Final = "episodes.jsonl"


class EpisodeRow(Struct, frozen=True, kw_only=True):
    """Entry of the index for one episode."""

    episode: int
    """Number of the episode, starting at 0."""
    file: str
    """File name of the recording in the same folder."""
    outcome: Outcome
    task: str
    """Description of the task."""
    duration: float
    """Duration of the episode in simulated time [s]."""
    wall_start: float
    """Wall time at which the episode began [s since 1970 UTC]."""


def read_index(folder: Path) -> list[EpisodeRow]:
    """Return the episodes in a folder's index; an incomplete last line is ignored.

    Raises:
        RecordingError: If the folder has no index, or a line in it is invalid.
    """
    path = folder / INDEX
    try:
        lines = path.read_bytes().split(b"\n")[:-1]
    except FileNotFoundError:
        raise RecordingError(
            f"{folder} has no {INDEX}: it is no folder of episodes; "
            "`tool0 record --episodes FOLDER` makes one"
        ) from None
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror}") from error
    rows = []
    for number, line in enumerate(lines, start=1):
        try:
            rows.append(msgspec.json.decode(line, type=EpisodeRow))
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            raise RecordingError(f"{path}, line {number}: {error}") from None
    return rows


@final
class Episodes:
    """Service that records episodes, from ``simulation.service(Episodes)``."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._lock = threading.Lock()
        self._folder: Path | None = None
        self._task = ""
        self._resets = True
        self._rows: list[EpisodeRow] = []
        self._wall_start: float | None = None
        """Wall time at which the current episode began [s since 1970 UTC]; None if
        there is no current episode."""
        self._error: str | None = None

    @property
    def status(self) -> EpisodesStatus | None:
        folder = self._folder
        if folder is None:
            return None
        recording = self._recording
        return EpisodesStatus(
            folder=str(folder),
            task=self._task,
            is_recording=recording is not None,
            duration=0.0 if recording is None else recording.duration,
            episodes=len(self._rows),
            succeeded=sum(row.outcome == "success" for row in self._rows),
            error=self._error,
        )

    def open(self, folder: Path, task: str, *, resets: bool) -> EpisodesStatus:
        """Open a folder for episodes, which may already contain episodes.

        Raises:
            RecordingError: If the folder contains other files or is not writable.
            ControlError: If an episode is being recorded.
        """
        with self._lock:
            if self._wall_start is not None:
                raise ControlError("an episode is being recorded; end it first")
            try:
                folder.mkdir(parents=True, exist_ok=True)
                others = [path.name for path in folder.iterdir()]
                if others and INDEX not in others:
                    raise RecordingError(
                        f"{folder} has other files ({min(others)}): give an empty or "
                        "a new folder"
                    )
                (folder / INDEX).touch()
            except OSError as error:
                raise RecordingError(f"cannot use {folder}: {error.strerror}") from None
            self._rows = read_index(folder)
            self._folder, self._task, self._resets = folder, task, resets
            self._error = None
            return self._status()

    def start(self) -> EpisodesStatus:
        """Start an episode.

        If the folder was opened with ``resets``, the robot is reset first.

        Raises:
            ControlError: If no folder is open, or a recording is in progress.
            RecordingError: If the episode's file cannot be written.
        """
        with self._lock:
            if self._recording is not None:
                raise ControlError("an episode is being recorded; end it first")
            file = self._file()
            recordings = self._simulation.service(Recordings)
            status = recordings.status
            if status is not None and status.is_recording:
                raise ControlError(
                    f"a recording to {status.file} is in progress; stop it first"
                )
            self._error = None
            if self._resets:
                answer(self._simulation, Reset())
            recordings.start(file, overwrite=True)  # only indexed files are episodes
            self._wall_start = time.time()
            return self._status()

    def end(self, outcome: EpisodeEnd) -> EpisodesStatus:
        """End the episode, and add it to the index or discard it.

        Raises:
            ControlError: If no episode is being recorded.
            RecordingError: If the recording ended early or was divided by a reset, in
                which case the episode is discarded.
        """
        with self._lock:
            wall_start, file = self._wall_start, self._file()
            if wall_start is None:
                raise ControlError("no episode is being recorded; start one first")
            self._wall_start = None
            recording = self._simulation.service(Recordings).stop()
            problem = recording.error
            if recording.files > 1:
                problem = "time began again during the episode: the robot was reset"
            if problem is not None or outcome == "discard":
                self._discard(file, recording.files)
            if problem is not None:
                self._error = problem
                raise RecordingError(f"the episode was discarded: {problem}")
            if outcome != "discard":
                row = EpisodeRow(
                    episode=len(self._rows),
                    file=file.name,
                    outcome=outcome,
                    task=self._task,
                    duration=recording.duration,
                    wall_start=round(wall_start, 3),
                )
                self._add(file.parent / INDEX, row)
            return self._status()

    def close(self) -> None:
        """Close the folder and discard an episode that is being recorded."""
        with self._lock:
            if self._folder is not None and self._wall_start is not None:
                recording = self._simulation.service(Recordings).stop()
                self._discard(self._file(), recording.files)
            self._wall_start = self._folder = None

    @property
    def _recording(self) -> RecordingStatus | None:
        """Status of the episode's recording; None if there is no current episode."""
        if self._wall_start is None:
            return None
        return self._simulation.service(Recordings).status

    def _status(self) -> EpisodesStatus:
        status = self.status
        assert status is not None  # a folder is open
        return status

    def _file(self) -> Path:
        """Return the path of the current or next episode's file."""
        if self._folder is None:
            raise ControlError(
                "there is no folder for episodes; open one: "
                "`tool0 record --episodes FOLDER`"
            )
        return self._folder / f"episode_{len(self._rows):06d}.mcap"

    def _discard(self, file: Path, n_files: int) -> None:
        for number in range(1, n_files + 1):
            part = file if number == 1 else file.with_stem(f"{file.stem}_{number}")
            part.unlink(missing_ok=True)

    def _add(self, index: Path, row: EpisodeRow) -> None:
        line = json.dumps(msgspec.to_builtins(row), ensure_ascii=False)
        try:
            with index.open("ab") as stream:
                stream.write(f"{line}\n".encode())
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as error:
            raise RecordingError(f"cannot write {index}: {error.strerror}") from error
        self._rows.append(row)


@handles(OpenEpisodes)
def _open(simulation: Simulation, request: OpenEpisodes) -> EpisodesStatus:
    folder = given_path(request.folder)
    episodes = simulation.service(Episodes)
    return episodes.open(folder, request.task, resets=request.reset)


handles(CloseEpisodes)(lambda sim, _: sim.service(Episodes).close())
handles(StartEpisode)(lambda sim, _: sim.service(Episodes).start())
handles(EndEpisode)(lambda sim, request: sim.service(Episodes).end(request.outcome))
handles(ReadEpisodes)(lambda sim, _: sim.service(Episodes).status)
