"""What happens to a running robot, in words for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, final

from tool0.control.goal import Goal, GoalResult, GoalStatus, GripperResult
from tool0.interfaces.panel.protocol import NoticeCode, Severity
from tool0.interfaces.panel.source import Notification
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


@final
class EventWatcher:
    """Notices what happened between two looks."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._subscription = simulation.subscribe()
        self._before = simulation.snapshot
        self._reported: set[str] = set()
        self._waiting = [
            Notification(severity="warning", code="lint", text=str(warning))
            for warning in simulation.warnings
        ]

    def report_once(self, severity: Severity, code: NoticeCode, text: str) -> None:
        """Tell it at the next look, unless the same was told before."""
        if text not in self._reported:
            self._reported.add(text)
            self._waiting.append(Notification(severity=severity, code=code, text=text))

    def notifications(self) -> Sequence[Notification]:
        """Return what happened since the last call."""
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
    """Return at most MAX_AT_ONCE, the grave ones rather than the others."""
    if len(found) <= MAX_AT_ONCE:
        return found
    by_severity = sorted(found, key=lambda item: -_SEVERITY_ORDER[item.severity])
    kept = {id(item) for item in by_severity[:MAX_AT_ONCE]}
    text = f"… and {len(found) - MAX_AT_ONCE} more"
    more = Notification(severity="info", code="log", text=text, time=found[-1].time)
    return [*(item for item in found if id(item) in kept), more]


def _described(event: Event, now: float) -> Notification:
    match event:
        case GoalFinished(goal):
            severity, code = _GOAL_CODES[goal.status]
            return Notification(
                severity=severity, code=code, text=_outcome(goal), time=now
            )
        case Overran(count, time):
            ticks = "1 tick" if count == 1 else f"{count} ticks"
            text = f"{ticks} began late within a second"
            return Notification(
                severity="warning", code="overrun", text=text, time=time
            )
        case Faulted(message, time):
            return Notification(severity="error", code="fault", text=message, time=time)
        case WasReset(time):
            text = "the simulation was reset"
            return Notification(severity="info", code="reset", text=text, time=time)


def _outcome(goal: Goal) -> str:
    text = f"{goal.controller}: goal {goal.status.value.lower()}"
    match goal.result:
        case GoalResult(error_string=reason) if reason:
            return f"{text}: {reason}"
        case GripperResult(stalled=True):
            return f"{text}: the gripper stands still before its goal"
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
    if now.controllers != before.controllers:
        old = {status.name: status.state for status in before.controllers}
        new = {status.name: status.state for status in now.controllers}
        changed = [
            f"{name} {new.get(name, 'unloaded')}"
            for name in {**old, **new}
            if old.get(name) != new.get(name)
        ]
        if changed:
            text = ", ".join(changed)
            found.append(
                Notification(
                    severity="info", code="controllers", text=text, time=now.time
                )
            )
    return found
