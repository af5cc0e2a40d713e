"""The folder of a data set, with one file and one index row per episode.

Episodes are added in order, so a data set always consists of the episodes 0 … n-1.  A
file is written to the disk and then renamed to its final name; finally, its row is
appended to the index.  Files without a row, which an interruption may leave behind, are
removed when the folder is opened again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

from tool0.collect import lerobot
from tool0.collect.settings import Settings, differences, programs
from tool0.errors import CollectError, ConfigError
from tool0.user_data import locked

MANIFEST: Final = "manifest.json"
EPISODES: Final = "episodes.jsonl"
_DATA_PATH: Final = "data/chunk-{:03d}/episode_{:06d}.parquet"
_COUNTS: Final = {"length", "success", "bytes"}
"""Keys that every row of the index must have."""
_PART: Final = ".part"
_WRITERS: Final = 8
"""Number of files that are written at the same time."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Manifest:
    """The content of a folder of episodes."""

    folder: Path
    n_episodes: int
    """Number of episodes in the folder."""
    n_requested: int
    """Number of episodes that the folder should contain."""
    n_succeeded: int
    n_frames: int
    """Total number of actions in all episodes."""
    n_bytes: int
    """Total size of the episodes' files [bytes]."""

    @property
    def is_complete(self) -> bool:
        """Whether the folder contains all requested episodes."""
        return self.n_episodes >= self.n_requested


@final
class Dataset:
    """Folder of a data set to which only this process adds episodes."""

    def __init__(self, folder: Path, settings: Settings, n_requested: int) -> None:
        """Recover the folder; see ``opened``."""
        self._folder = folder
        self._settings = settings
        self._n_requested = n_requested
        self._is_lerobot = settings.format == "lerobot"
        self.recover()

    def recover(self) -> None:
        """Keep the complete episodes, and remove incomplete files.

        Raises:
            CollectError: If the file of a complete episode is missing, or its size
                differs from the size in its row.
        """
        rows = self._recovered()
        self._lengths = [row["length"] for row in rows]
        self._n_succeeded = sum(row["success"] for row in rows)
        self._n_frames = sum(self._lengths)
        self._n_bytes = sum(row["bytes"] for row in rows)

    @property
    def manifest(self) -> Manifest:
        """The current content of the folder."""
        return Manifest(
            folder=self._folder,
            n_episodes=len(self._lengths),
            n_requested=self._n_requested,
            n_succeeded=self._n_succeeded,
            n_frames=self._n_frames,
            n_bytes=self._n_bytes,
        )

    def add(self, episodes: Sequence[tuple[dict[str, Any], bytes]]) -> None:
        """Append the next episodes.

        Raises:
            OSError: If a file cannot be written, for example because the disk is full.
                ``recover`` removes incomplete files.
        """
        rows, files, first_frame = [], {}, self._n_frames
        for row, sent in episodes:
            file = lerobot.placed(sent, first_frame) if self._is_lerobot else sent
            first_frame += row["length"]
            digest = hashlib.sha256(file).hexdigest()
            rows.append({**row, "bytes": len(file), "sha256": digest})
            files[self._path(row["episode_index"])] = file
        self._write(rows, files)
        self._lengths += [row["length"] for row in rows]
        self._n_frames = first_frame
        self._n_succeeded += sum(row["success"] for row in rows)
        self._n_bytes += sum(row["bytes"] for row in rows)

    def _path(self, index: int) -> Path:
        """Return the file of an episode."""
        if self._is_lerobot:
            return self._folder / lerobot.data_path(index)
        return self._folder / _DATA_PATH.format(index // lerobot.CHUNK, index)

    def _write(
        self, rows: Sequence[Mapping[str, Any]], files: Mapping[Path, bytes]
    ) -> None:
        """Write the files and then the rows, and flush both to the disk."""
        parts = [_part(path) for path in files]
        with ThreadPoolExecutor(_WRITERS) as pool:  # one flush for many files
            writes = [
                pool.submit(_write, part, file)
                for part, file in zip(parts, files.values(), strict=True)
            ]
        for write in writes:
            write.result()
        for path in files:
            _part(path).replace(path)
        for folder in {path.parent for path in files}:
            _flush_folder(folder)
            _flush_folder(folder.parent)  # the parent may contain a new folder
        lines = "".join(f"{json.dumps(row)}\n" for row in rows)
        with (self._folder / EPISODES).open("ab") as stream:
            stream.write(lines.encode())
            stream.flush()
            os.fsync(stream.fileno())

    def describe(self) -> None:
        """Write the manifest and, for the LeRobot format, the files in ``meta``."""
        found = self.manifest
        manifest = {
            **self._settings.recorded(),
            "episodes": self._n_requested,
            "complete": found.is_complete,
            "collected": found.n_episodes,
            "succeeded": found.n_succeeded,
            "frames": found.n_frames,
            "bytes": found.n_bytes,
            "programs": programs(),
        }
        text = f"{json.dumps(manifest, indent=2)}\n"
        _replace(self._folder / MANIFEST, text.encode())
        if self._is_lerobot and found.n_episodes:
            for name, content in lerobot.descriptions(
                self._folder, self._lengths, self._settings.instruction
            ):
                _replace(self._folder / name, content)

    # ---- opening ---------------------------------------------------------------------

    def _recovered(self) -> list[dict[str, Any]]:
        log = self._folder / EPISODES
        lines = _lines(log)
        rows: list[dict[str, Any]] = []
        for index, line in enumerate(lines):
            path, row = self._path(index), _row(log, index, line)
            if not path.exists() or path.stat().st_size != row["bytes"]:
                raise CollectError(
                    f"{path} is missing or has another size than {EPISODES} says; "
                    "collect into another folder"
                )
            rows.append(row)
        log.touch()
        os.truncate(log, sum(len(line) + 1 for line in lines))
        kept = {self._path(index) for index in range(len(rows))}
        for pattern in (f"**/*{_PART}", "data/chunk-*/*.parquet"):
            for path in self._folder.glob(pattern):
                if path not in kept:
                    path.unlink()
        return rows


@contextlib.contextmanager
def opened(folder: Path, settings: Settings, n_requested: int) -> Iterator[Dataset]:
    """Create or reopen the folder of a data set, and write its manifest at the end.

    Raises:
        ConfigError: If the folder contains other episodes or unrelated files, or
            another process uses it.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_new = not (folder / MANIFEST).exists()
        is_empty = not _lines(folder / EPISODES)
        others = [path.name for path in folder.iterdir() if path.name != _LOCK]
    except OSError as error:
        raise ConfigError(f"{folder}: {error.strerror}") from None
    if is_new and any(not name.endswith(_PART) for name in others):
        raise ConfigError(
            f"{folder} has other files ({others[0]}): give an empty or a new folder"
        )
    with contextlib.ExitStack() as exits:
        try:
            exits.enter_context(locked(folder / _LOCK, wait=False))
        except BlockingIOError:
            raise ConfigError(f"another process collects into {folder}") from None
        if not is_empty:
            _check(folder, settings)
        dataset = Dataset(folder, settings, n_requested)
        n = dataset.manifest.n_episodes
        if n > n_requested:
            raise ConfigError(f"{folder} has {n} episodes, more than {n_requested}")
        dataset.describe()
        try:
            yield dataset
        except BaseException:
            with contextlib.suppress(OSError):  # such as on a full disk
                dataset.recover()
                dataset.describe()
            raise
        dataset.describe()


_LOCK: Final = ".lock"


def _check(folder: Path, settings: Settings) -> None:
    path = folder / MANIFEST
    try:
        manifest = json.loads(path.read_bytes())
        recorded = {key: manifest.get(key) for key in settings.recorded()}
        made_by = manifest["programs"]
    except (ValueError, KeyError, AttributeError):
        raise ConfigError(f"{path} is no manifest of tool0") from None
    if found := differences(settings.recorded(), recorded):
        raise ConfigError(
            f"{folder} was collected with {', '.join(found)}: give the same "
            "parameters to continue it, or another folder"
        )
    if found := differences(programs(), made_by):
        raise ConfigError(
            f"{folder} was collected with {', '.join(found)}, and further episodes "
            "would not be the same: collect into another folder"
        )


# ---- rows and files ------------------------------------------------------------------


def _part(path: Path) -> Path:
    """Return the temporary name of a file that is being written."""
    return path.with_name(path.name + _PART)


def _row(log: Path, index: int, line: bytes) -> dict[str, Any]:
    """Return the row on a line of the index, or raise CollectError."""
    with contextlib.suppress(ValueError):
        row = json.loads(line)
        if isinstance(row, dict) and row.keys() >= _COUNTS:
            return row
    raise CollectError(
        f"{log}, line {index + 1}: this is no row about an episode; the file is damaged"
    )


def _lines(path: Path) -> list[bytes]:
    """Return the complete lines of a log; an incomplete last line is ignored."""
    text = path.read_bytes() if path.exists() else b""
    return text.split(b"\n")[:-1]


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with path.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
    except OSError:
        path.unlink(missing_ok=True)
        raise


def _replace(path: Path, content: bytes) -> None:
    """Replace a file atomically, so that either the old or the new version exists."""
    _write(_part(path), content)
    _part(path).replace(path)
    _flush_folder(path.parent)


def _flush_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
