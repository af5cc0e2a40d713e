"""A recording's events as notices for a page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, cast, get_args

from tool0.panel.protocol import Notice
from tool0.protocol.notifications import NoticeCode, Severity

if TYPE_CHECKING:
    from tool0.recording.reading import RecordingFile

MOST: Final = 20_000
"""Maximum number of notices.  If there are more events, only the first notices are
sent."""
_CODES: Final = frozenset(get_args(NoticeCode))


def notices_of(recording: RecordingFile) -> list[Notice]:
    """Return notices of the recording's events and grips in chronological order."""
    found = sorted([*_events(recording), *_grips(recording)], key=lambda item: item[0])
    start = float(recording.time[0])
    return [
        Notice(
            number=number,
            # as if the recording had been made in real time
            wall_time=round(recording.info.wall_start + time - start, 3),
            time=round(time, 3),
            severity=severity,
            code=code,
            text=text,
        )
        for number, (time, severity, code, text) in enumerate(found[:MOST], 1)
    ]


def _events(
    recording: RecordingFile,
) -> Iterator[tuple[float, Severity, NoticeCode, str]]:
    for event in recording.events:
        code = event.kind if event.kind in _CODES else "log"
        yield (
            event.time,
            cast(Severity, event.severity),
            cast(NoticeCode, code),
            event.text,
        )


def _grips(
    recording: RecordingFile,
) -> Iterator[tuple[float, Severity, NoticeCode, str]]:
    """Yield an event when a gripper's fingers start or stop pressing on an object."""
    before: frozenset[str] = frozenset()
    for frame, gripping in recording.gripping:
        now, time = frozenset(gripping), float(recording.time[frame])
        for name in sorted(now - before):
            yield time, "info", "contact", f"gripper '{name}' holds something"
        for name in sorted(before - now):
            yield time, "info", "contact", f"gripper '{name}' holds nothing any more"
        before = now
