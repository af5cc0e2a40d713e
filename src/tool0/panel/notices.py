"""Notices, which are numbered messages to users about a robot's events."""

from __future__ import annotations

import re
import time
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, final

from tool0.panel.protocol import Notice
from tool0.protocol.notifications import Notification, Severity, changes, described

if TYPE_CHECKING:
    from tool0.protocol.backend import States

MAX_AT_ONCE: Final = 20
"""Maximum number of notifications per update.  The limit is needed because a script can
end thousands of goals at the same time."""
_SEVERITY_ORDER: Final[dict[Severity, int]] = {"info": 0, "warning": 1, "error": 2}
NOTICES_KEPT: Final = 200
_REPEAT_AFTER: Final = 5.0
"""Wall time after which a repeated refusal is shown again [s].  Sliders cause repeated
refusals with different numbers."""
_ONE_OVERRUN: Final = 60.0
"""Wall time within which repeated reports of late ticks are combined into one notice
[s]."""
_NUMBER: Final = re.compile(r"-?\d+(\.\d+)?")


@final
class NoticeBook:
    """Numbers notices and keeps the latest notices for pages that connect later."""

    def __init__(self) -> None:
        self._number = 0
        self._refusals: dict[str, float] = {}
        self.kept: deque[Notice] = deque(maxlen=NOTICES_KEPT)

    def note(self, notification: Notification) -> Notice | None:
        """Return a notification as a notice, or None if it is repeated too early."""
        now = time.time()
        text = notification.text
        if notification.code == "refused" and self._is_repeated(text, now):
            return None
        self._number += 1
        notice = Notice(
            number=self._number,
            wall_time=round(now, 3),
            time=None if notification.time is None else round(notification.time, 3),
            severity=notification.severity,
            code=notification.code,
            text=text,
        )
        self._forget_overrun(notice)
        self.kept.append(notice)
        return notice

    def _forget_overrun(self, now: Notice) -> None:
        """Drop the previous overrun notice if the new notice continues it."""
        for earlier in reversed(self.kept):
            if now.wall_time - earlier.wall_time > _ONE_OVERRUN:
                return
            if now.code == earlier.code == "overrun":
                self.kept.remove(earlier)
                return

    def _is_repeated(self, text: str, now: float) -> bool:
        self._refusals = {
            kind: since
            for kind, since in self._refusals.items()
            if now - since < _REPEAT_AFTER
        }
        kind = _NUMBER.sub("#", text)
        is_repeated = kind in self._refusals
        self._refusals.setdefault(kind, now)
        return is_repeated


@final
class EventWatcher:
    """Describes the events and changes of a robot as notifications."""

    def __init__(self, states: States, warnings: Sequence[str]) -> None:
        """Watch a robot's states; ``warnings`` are the first notifications."""
        self._states = states
        self._subscription = states.subscribe()
        self._before = states.snapshot
        self._reported: set[str] = set()
        self._waiting = [
            Notification(severity="warning", code="lint", text=warning)
            for warning in warnings
        ]

    def report_once(self, text: str) -> None:
        """Add a warning to the next ``notifications`` unless it was already added."""
        if text not in self._reported:
            self._reported.add(text)
            self._waiting.append(
                Notification(severity="warning", code="log", text=text)
            )

    def notifications(self) -> Sequence[Notification]:
        """Return the notifications since the last call.

        The first call adds the warnings.
        """
        found, self._waiting = self._waiting, []
        snapshot = self._states.snapshot
        events = self._subscription.events
        while events:
            found.append(described(events.popleft(), snapshot.time))
        if snapshot is not self._before:
            found += changes(self._before, snapshot)
            self._before = snapshot
        return _shortened(found)

    def close(self) -> None:
        self._subscription.close()


def _shortened(found: list[Notification]) -> list[Notification]:
    """Return the most severe notifications and a summary of the others."""
    if len(found) <= MAX_AT_ONCE:
        return found
    by_severity = sorted(found, key=lambda item: -_SEVERITY_ORDER[item.severity])
    kept = {id(item) for item in by_severity[:MAX_AT_ONCE]}
    text = f"… and {len(found) - MAX_AT_ONCE} more"
    more = Notification(severity="info", code="log", text=text, time=found[-1].time)
    return [*(item for item in found if id(item) in kept), more]
