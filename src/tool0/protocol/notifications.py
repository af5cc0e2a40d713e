"""Text about the events of a robot, for users and recordings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, final

from tool0.protocol.bus import (
    Event,
    Faulted,
    GoalFinished,
    Overran,
    Reported,
    WasFrozen,
    WasReset,
)
from tool0.protocol.control_box_state import ControlBoxState, SafetyMode
from tool0.protocol.goals import Goal, GoalResult, GoalStatus, GripperResult

if TYPE_CHECKING:
    from tool0.protocol.state import Snapshot

Severity = Literal["info", "warning", "error"]
NoticeCode = Literal[
    "lint",
    "goal_succeeded",
    "goal_aborted",
    "goal_preempted",
    "overrun",
    "stall",
    "fault",
    "reset",
    "emergency_stop",
    "protective_stop",
    "arm_modes",
    "controllers",
    "recording",
    "refused",
    "contact",
    "log",
]
_GOAL_CODES: Final[dict[GoalStatus, tuple[Severity, NoticeCode]]] = {
    GoalStatus.SUCCEEDED: ("info", "goal_succeeded"),
    GoalStatus.PREEMPTED: ("info", "goal_preempted"),
    GoalStatus.ABORTED: ("error", "goal_aborted"),
}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Notification:
    """A message to users."""

    severity: Severity
    code: NoticeCode
    text: str
    time: float | None = None
    """Simulated time [s]."""


def described(event: Event, now: float) -> Notification:
    """Return the description of an event.

    The time ``now`` [s] is used for an event without a time.
    """
    time = now if event.time is None else event.time
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
        case Reported(message):
            severity, code, text = "warning", "recording", message
        case WasFrozen(duration):
            severity, code, text = "warning", "log", frozen_text(duration)
    return Notification(severity=severity, code=code, text=text, time=time)


def frozen_text(duration: float) -> str:
    """Return the message for a process that was frozen for ``duration`` [wall s]."""
    return (
        f"the simulator stood still for {duration:.1f} s, as when its process is "
        "stopped or the machine sleeps: every motion was stopped"
    )


def _outcome(goal: Goal) -> str:
    text = f"{goal.controller}: goal {goal.status.value.lower()}"
    match goal.result:
        case GoalResult(error_string=reason) if reason:
            return f"{text}: {reason}"
        case GripperResult(stalled=True, error_string=reason):
            return f"{text}: the gripper stopped before its goal: {reason}"
    return text


def changes(before: Snapshot, now: Snapshot) -> list[Notification]:
    """Return descriptions of the events between two snapshots."""
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
    """Return descriptions of an arm's mode changes, other than the emergency stop."""
    arm, time = f"arm '{now.arm}'", snapshot.time
    found: list[tuple[Severity, NoticeCode, str]] = []
    if now.protective_stop and now.protective_stop != before.protective_stop:
        text = f"{arm}: protective stop: {now.protective_stop}"
        found.append(("warning", "protective_stop", text))
    elif before.protective_stop and not now.protective_stop:
        found.append(("info", "protective_stop", f"{arm}: protective stop unlocked"))
    failure = now.motion_failure
    if failure and failure != before.motion_failure and not snapshot.is_stopped:
        found.append(("warning", "arm_modes", f"{arm} stops where it is: {failure}"))
    if now.taken_by != before.taken_by:
        text = f"is moved by '{now.taken_by}'" if now.taken_by else "is released"
        found.append(("info", "arm_modes", f"{arm} {text}"))
    is_hidden = SafetyMode.ROBOT_EMERGENCY_STOP in (now.safety_mode, before.safety_mode)
    if now.robot_mode is not before.robot_mode and not is_hidden:
        words = now.robot_mode.name.lower().replace("_", " ")
        found.append(("info", "arm_modes", f"{arm}: {words}"))
    return [
        Notification(severity=severity, code=code, text=text, time=time)
        for severity, code, text in found
    ]
