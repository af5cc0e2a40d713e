"""Notices: numbered messages to users about what happens to a robot."""

from __future__ import annotations

import re
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

from tool0.control.goal import Goal, GoalResult, GoalStatus, GripperResult
from tool0.hardware.control_box import ControlBoxState, SafetyMode
from tool0.interfaces.panel.protocol import Notice, NoticeCode, Severity
from tool0.runtime.bus import Event, Faulted, GoalFinished, Overran, WasReset

if TYPE_CHECKING:
    from tool0.runtime.simulation import Simulation
    from tool0.sensing.snapshot import Snapshot

MAX_AT_ONCE: Final = 20
"""Notifications that are shown one by one: a script can end thousands of goals."""
_SEVERITY_ORDER: Final[dict[Severity, int]] = {"info": 0, "warning": 1, "error": 2}
_GOAL_CODES: Final[dict[GoalStatus, tuple[Severity, NoticeCode]]] = {
    GoalStatus.SUCCEEDED: ("info", "goal_succeeded"),
    GoalStatus.PREEMPTED: ("info", "goal_preempted"),
    GoalStatus.ABORTED: ("error", "goal_aborted"),
}
NOTICES_KEPT: Final = 200
_REPEAT_AFTER: Final = 5.0
"""Wall time after which the same refusal is noted again [s]: sliders repeat it
with other numbers."""
_NUMBER: Final = re.compile(r"-?\d+(\.\d+)?")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Notification:
    """A message to the users."""

    severity: Severity
    code: NoticeCode
    text: str
    time: float | None = None
    """Simulated [s]."""


@final
class NoticeBook:
    """Numbers notices and keeps the last ones for pages that connect later."""

    def __init__(self) -> None:
        self._number = 0
        self._refusals: dict[str, float] = {}
        self.kept: deque[Notice] = deque(maxlen=NOTICES_KEPT)

    def note(self, notification: Notification) -> Notice | None:
        """Return the notice; None for a refusal that was noted a moment ago."""
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
        self.kept.append(notice)
        return notice

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
    """Describes the events and the changes of a simulation."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._subscription = simulation.subscribe()
        self._before = simulation.snapshot
        self._reported: set[str] = set()
        self._waiting = [
            Notification(severity="warning", code="lint", text=str(warning))
            for warning in simulation.warnings
        ]

    def report_once(self, text: str) -> None:
        """Return a warning with the next ``notifications``, unless sent before."""
        if text not in self._reported:
            self._reported.add(text)
            self._waiting.append(
                Notification(severity="warning", code="log", text=text)
            )

    def notifications(self) -> Sequence[Notification]:
        """Return the events since the last call; at first, the YAML's findings."""
        found, self._waiting = self._waiting, []
        snapshot = self._simulation.snapshot
        events = self._subscription.events
        while events:
            found.append(_described(events.popleft(), snapshot.time))
        if snapshot is not self._before:
            found += _changes(self._before, snapshot)
            self._before = snapshot
        return _shortened(found)

    def close(self) -> None:
        self._subscription.close()


def _shortened(found: list[Notification]) -> list[Notification]:
    """Return at most MAX_AT_ONCE, the most severe ones."""
    if len(found) <= MAX_AT_ONCE:
        return found
    by_severity = sorted(found, key=lambda item: -_SEVERITY_ORDER[item.severity])
    kept = {id(item) for item in by_severity[:MAX_AT_ONCE]}
    text = f"… and {len(found) - MAX_AT_ONCE} more"
    more = Notification(severity="info", code="log", text=text, time=found[-1].time)
    return [*(item for item in found if id(item) in kept), more]


def _described(event: Event, now: float) -> Notification:
    time = now if isinstance(event, GoalFinished) else event.time
    match event:
        case GoalFinished(goal):
            severity, code = _GOAL_CODES[goal.status]
            text = _outcome(goal)
        case Overran(count):
            severity, code = "warning" if count else "info", "overrun"
            text = (
                f"the simulation falls behind: {count} late ticks in a second"
                if count
                else "the simulation keeps up again"
            )
        case Faulted(message):
            severity, code, text = "error", "fault", message
        case WasReset():
            severity, code, text = "info", "reset", "the simulation was reset"
    return Notification(severity=severity, code=code, text=text, time=time)


def _outcome(goal: Goal) -> str:
    text = f"{goal.controller}: goal {goal.status.value.lower()}"
    match goal.result:
        case GoalResult(error_string=reason) if reason:
            return f"{text}: {reason}"
        case GripperResult(stalled=True):
            return f"{text}: the gripper stopped before its goal"
    return text


def _changes(before: Snapshot, now: Snapshot) -> list[Notification]:
    found = []
    if now.is_stopped != before.is_stopped:
        found.append(
            Notification(
                severity="warning" if now.is_stopped else "info",
                code="emergency_stop",
                text=f"emergency stop {'engaged' if now.is_stopped else 'released'}",
                time=now.time,
            )
        )
    if now.control_boxes is not before.control_boxes:
        pairs = zip(before.control_boxes, now.control_boxes, strict=True)
        for old_box, box in pairs:
            found += _mode_changes(old_box, box, now)
    known = {stall.joint for stall in before.stalls}
    found += [
        Notification(severity="warning", code="stall", text=str(stall), time=now.time)
        for stall in now.stalls
        if stall.joint not in known
    ]
    if now.controllers != before.controllers:
        old = {status.name: status.state for status in before.controllers}
        new = {status.name: status.state for status in now.controllers}
        changed = ", ".join(
            f"{name} {new.get(name, 'unloaded')}"
            for name in {**old, **new}
            if old.get(name) != new.get(name)
        )
        if changed:
            found.append(
                Notification(
                    severity="info", code="controllers", text=changed, time=now.time
                )
            )
    return found


def _mode_changes(
    before: ControlBoxState, now: ControlBoxState, snapshot: Snapshot
) -> list[Notification]:
    """Return what was stopped, powered or taken; the emergency stop is no such."""
    arm, time = f"arm '{now.arm}'", snapshot.time
    found: list[tuple[Severity, NoticeCode, str]] = []
    if now.protective_stop and now.protective_stop != before.protective_stop:
        text = f"{arm}: protective stop: {now.protective_stop}"
        found.append(("warning", "protective_stop", text))
    elif before.protective_stop and not now.protective_stop:
        found.append(("info", "protective_stop", f"{arm}: protective stop unlocked"))
    if now.taken_by != before.taken_by:
        text = f"is moved by '{now.taken_by}'" if now.taken_by else "is given back"
        found.append(("info", "arm_modes", f"{arm} {text}"))
    is_hidden = SafetyMode.ROBOT_EMERGENCY_STOP in (now.safety_mode, before.safety_mode)
    if now.robot_mode is not before.robot_mode and not is_hidden:
        words = now.robot_mode.name.lower().replace("_", " ")
        found.append(("info", "arm_modes", f"{arm}: {words}"))
    return [
        Notification(severity=severity, code=code, text=text, time=time)
        for severity, code, text in found
    ]
