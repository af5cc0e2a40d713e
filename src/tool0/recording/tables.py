"""Writes a recording to a file as a table, and its events as lines of text."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from tool0.errors import RecordingError
from tool0.recording.entries import RecordedEvent, RecordedRequest

if TYPE_CHECKING:
    from tool0.protocol.notifications import Severity
    from tool0.recording.reading import RecordingFile

_ORDER: Final = ("info", "warning", "error")
_LONGEST: Final = 120
"""Maximum length of a request's parameters in a line of text [characters]."""


def write_csv(recording: RecordingFile, path: Path) -> None:
    """Write a CSV file with a line per snapshot; missing values are empty fields.

    Raises:
        RecordingError: If the file cannot be written.
    """
    columns = {"time": recording.time, **recording.table()}
    rows = np.stack(list(columns.values()), axis=1).tolist()
    try:
        with path.open("w", encoding="utf-8") as file:
            file.write(",".join(map(_quoted, columns)) + "\n")
            for row in rows:
                fields = ("" if math.isnan(value) else repr(value) for value in row)
                file.write(",".join(fields) + "\n")
    except OSError as error:
        raise RecordingError(f"cannot write {path}: {error.strerror}") from error


def write_parquet(recording: RecordingFile, path: Path) -> None:
    """Write a Parquet file with the same columns as the CSV file.

    Raises:
        RecordingError: If the file cannot be written, or pyarrow is not installed.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise RecordingError(
            "Parquet needs pyarrow, which is not installed: pip install pyarrow"
        ) from None
    table = pa.table({"time": recording.time, **recording.table()})
    try:
        pq.write_table(table, path)
    except OSError as error:
        raise RecordingError(f"cannot write {path}: {error.strerror}") from error


def log_entries(
    recording: RecordingFile, *, severity: Severity = "info", requests: bool = True
) -> list[RecordedEvent | RecordedRequest]:
    """Return the events and requests of a recording in chronological order.

    Args:
        recording: The recording.
        severity: Lowest severity of the events.
        requests: Whether to include the requests that were executed during the
            recording.
    """
    least = _ORDER.index(severity)
    found: list[RecordedEvent | RecordedRequest] = [
        event for event in recording.events if _ORDER.index(event.severity) >= least
    ]
    if requests:
        first = int(recording.step[0]) if len(recording) else 0
        found += [item for item in recording.requests if item.step >= first]
    return sorted(found, key=lambda item: item.time)


def log_line(entry: RecordedEvent | RecordedRequest) -> str:
    """Return an event or a request as a line of text."""
    if isinstance(entry, RecordedEvent):
        text = f"{entry.severity:8} {entry.text}"
    else:
        text = f"{'request':8} {entry.method} {_shortened(entry.params)}".rstrip()
    return f"{entry.time:10.3f} s  {text}"


def _shortened(params: object) -> str:
    text = json.dumps(params, separators=(", ", ": ")) if params else ""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} …"


def _quoted(name: str) -> str:
    """Return a column's name with CSV quoting, because objects may have any name."""
    if any(character in name for character in ',"\n'):
        return '"' + name.replace('"', '""') + '"'
    return name
