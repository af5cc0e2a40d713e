"""Events as text on ``/rosout`` and as JSON on ``/tool0/events``."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any, Final, final

import msgspec

from tool0.description.model import RobotModel
from tool0.description.scene_state import Contact
from tool0.protocol.bus import Event, GoalFinished, Subscription, WasReset
from tool0.protocol.codec import outcome_of
from tool0.protocol.notifications import Notification, Severity, changes, described
from tool0.protocol.state import Snapshot
from tool0.recording.cdr import encode_text
from tool0.recording.frames import stamp
from tool0.recording.mcap_file import McapFile
from tool0.recording.message_types import LOG, TEXT, message, stamp_of

EVENTS: Final = "/tool0/events"
ROSOUT: Final = "/rosout"
_LEVELS: Final[dict[Severity, int]] = {"info": 20, "warning": 30, "error": 40}
_APART: Final = 0.5
"""Time without contact after which another contact of the same pair is a new event
[s]."""


@final
class EventQueue:
    """Merger of events with the sequence of snapshots.

    Events and snapshots are each received in order, but separately, and snapshots may
    be delayed.
    """

    def __init__(self, subscription: Subscription) -> None:
        self._arrived = subscription.events
        self._waiting: deque[Event] = deque()

    def before(self, snapshot: Snapshot, last: Snapshot | None) -> Iterator[Event]:
        """Yield the events between the snapshots ``last`` and ``snapshot``."""
        waiting = self._waiting
        while self._arrived:
            waiting.append(self._arrived.popleft())
        if last is not None and snapshot.time < last.time:  # time was reset
            while waiting:
                yield (event := waiting.popleft())
                if isinstance(event, WasReset):
                    break
        while waiting:
            event = waiting[0]
            if isinstance(event, WasReset) and not (
                snapshot.step > event.step
                or (snapshot.step == event.step and snapshot.time == event.time)
            ):
                return  # snapshots before the reset are still missing
            if event.time is not None and event.time > snapshot.time:
                return
            yield waiting.popleft()

    def rest(self) -> Iterator[Event]:
        """Yield the remaining events at the end of the recording."""
        yield from self._waiting
        yield from self._arrived


@final
class EventWriter:
    """Writer of events and changes between snapshots to one file."""

    def __init__(self, file: McapFile) -> None:
        self._file = file

    def write_event(self, event: Event, now: float) -> None:
        """Add an event from the bus; ``now`` [s] is used for events without a time."""
        data: dict[str, Any] = {}
        if isinstance(event, GoalFinished) and event.goal.result is not None:
            outcome = msgspec.to_builtins(outcome_of(event.goal.result))
            data = {"controller": event.goal.controller, **outcome}
        self._write(described(event, now), now, data)

    def write_changes(self, before: Snapshot, snapshot: Snapshot) -> None:
        """Add the events that result from the differences between two snapshots."""
        for item in changes(before, snapshot):
            self._write(item, snapshot.time, {})

    def write_contact(self, contact: Contact, now: float) -> None:
        """Add an event for a new contact of the robot."""
        force = math.hypot(*contact.force)
        text = f"'{contact.first}' touches '{contact.second}' with {force:.1f} N"
        found = Notification(severity="info", code="contact", text=text, time=now)
        bodies = {"first": contact.first, "second": contact.second}
        self._write(found, now, {**bodies, "force": force})

    def _write(self, found: Notification, now: float, data: Mapping[str, Any]) -> None:
        time = now if found.time is None else found.time
        event = {
            "time": time,
            "kind": found.code,
            "severity": found.severity,
            "text": found.text,
            "data": data,
        }
        at = stamp(time)
        self._file.write(EVENTS, TEXT, at, encode_text(msgspec.json.encode(event)))
        log = message(
            LOG,
            stamp=stamp_of(at),
            level=_LEVELS[found.severity],
            name="tool0",
            msg=found.text,
            file="",
            function="",
            line=0,
        )
        self._file.write(ROSOUT, LOG, at, log)


@final
class ContactWatch:
    """Detector of new contacts between the robot and its surroundings."""

    def __init__(self, model: RobotModel) -> None:
        self._links = frozenset(link.name for link in model.links)
        self._seen: dict[tuple[str, str], float] | None = None
        """Simulated time of each pair's last contact [s]; None before the first
        snapshot."""

    def begun(self, snapshot: Snapshot) -> list[Contact]:
        """Return the new contacts between the robot and its surroundings."""
        time, seen = snapshot.time, self._seen
        outer = [
            contact
            for contact in snapshot.contacts
            if (contact.first in self._links) != (contact.second in self._links)
        ]
        if seen is None or any(since > time for since in seen.values()):
            self._seen = {(item.first, item.second): time for item in outer}
            return []
        new = []
        for contact in outer:
            pair = contact.first, contact.second
            if time - seen.get(pair, -math.inf) > _APART:
                new.append(contact)
            seen[pair] = time
        return new
