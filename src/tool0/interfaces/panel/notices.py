"""What people are told, numbered; the last ones are kept for pages that come later."""

from __future__ import annotations

import re
import time
from collections import deque
from typing import Final, final

from tool0.interfaces.panel.protocol import Notice
from tool0.interfaces.panel.source import Notification

NOTICES_KEPT: Final = 200
_REPEAT_AFTER: Final = 5.0
"""Wall time after which the same refusal is told again [s]: sliders repeat it, with
other numbers."""
_NUMBER: Final = re.compile(r"-?\d+(\.\d+)?")


@final
class NoticeBook:
    """Makes notices of notifications."""

    def __init__(self) -> None:
        self._number = 0
        self._refusals: dict[str, float] = {}
        self.kept: deque[Notice] = deque(maxlen=NOTICES_KEPT)

    def note(self, notification: Notification) -> Notice | None:
        """Return the notice of it; None for a refusal that was told just now."""
        now = time.time()
        if notification.code == "refused" and self._was_reported(
            notification.text, now
        ):
            return None
        self._number += 1
        notice = Notice(
            number=self._number,
            wall_time=round(now, 3),
            time=None if notification.time is None else round(notification.time, 3),
            severity=notification.severity,
            code=notification.code,
            text=notification.text,
        )
        self.kept.append(notice)
        return notice

    def _was_reported(self, text: str, now: float) -> bool:
        recent = {
            told: when
            for told, when in self._refusals.items()
            if now - when < _REPEAT_AFTER
        }
        kind = _NUMBER.sub("#", text)
        is_known = kind in recent
        if not is_known:
            recent[kind] = now
        self._refusals = recent
        return is_known
