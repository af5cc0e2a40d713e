"""Stops planned motions at contacts that they do not expect."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import final

from tool0.description.model import RobotModel
from tool0.description.scene_state import Contact, contacts_text
from tool0.protocol.goals import Goal, GoalResult, GoalStatus, Result


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ContactWatch:
    """Finds contacts that a planned motion does not expect."""

    links: frozenset[str]
    """All that the motion moves."""
    carried: frozenset[str]
    """Objects that move with these: they may touch each other."""
    may_touch: frozenset[str]
    """Links and objects whose contacts do not count."""
    known: frozenset[frozenset[str]]
    """The pairs of the contacts at the start, which do not count either."""

    def unexpected(self, contacts: Collection[Contact]) -> str:
        """Return what touches and should not, as a sentence; empty if nothing does."""
        for contact in contacts:
            pair = _pair(contact)
            is_ours = not pair.isdisjoint(self.links | self.carried)
            is_allowed = pair in self.known or not pair.isdisjoint(self.may_touch)
            is_grip = not pair.isdisjoint(self.carried) and pair <= (
                self.links | self.carried
            )
            if is_ours and not is_allowed and not is_grip:
                text = contacts_text([(contact.first, contact.second)])
                return f"stopped: {text}, which the plan does not expect"
        return ""


@final
class PlanWatch:
    """Watches the goals of one planned motion."""

    def __init__(self, goals: Sequence[Goal], contacts: ContactWatch) -> None:
        """Watch from now on the ``goals`` of the controllers that follow it."""
        self.goals = tuple(goals)
        self.contacts = contacts

    @property
    def is_over(self) -> bool:
        """Whether every goal has ended."""
        return all(goal.status.is_terminal for goal in self.goals)

    def fail(self, reason: str) -> None:
        """Let the goals end as aborted, with a reason, when they are cancelled."""

        def explained(result: Result) -> Result:
            if not isinstance(result, GoalResult):
                return result
            return replace(result, status=GoalStatus.ABORTED, error_string=reason)

        for goal in self.goals:
            goal.explain = explained


def watch_contacts(
    model: RobotModel,
    joints: Iterable[str],
    contacts: Collection[Contact],
    *,
    carried: frozenset[str],
    may_touch: frozenset[str] = frozenset(),
) -> ContactWatch:
    """Return the watch of a motion of some joints that begins now.

    Args:
        model: The robot.
        joints: Those that move.
        contacts: Those at the start.
        carried: Objects that grippers hold.
        may_touch: Links and objects whose contacts do not count.
    """
    links = frozenset(
        link for name in joints for link in model.links_from(model.joint(name).child)
    )
    return ContactWatch(
        links=links,
        carried=carried,
        may_touch=may_touch,
        known=frozenset(map(_pair, contacts)),
    )


def _pair(contact: Contact) -> frozenset[str]:
    return frozenset((contact.first, contact.second))
