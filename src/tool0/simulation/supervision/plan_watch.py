"""Stops planned motions at contacts that they do not expect."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import final

from tool0.description.scene_state import Contact, contacts_text
from tool0.protocol.goals import Goal, GoalResult, GoalStatus, Result


@final
class PlanWatch:
    """Watches the goals of one planned motion."""

    def __init__(
        self,
        goals: Sequence[Goal],
        *,
        links: frozenset[str],
        carried: frozenset[str],
        may_touch: frozenset[str],
        contacts: Collection[Contact],
    ) -> None:
        """Watch from now on.

        Args:
            goals: Of the controllers that follow it.
            links: All that their joints move.
            carried: Objects that move with these: they may touch each other.
            may_touch: Links and objects whose contacts do not count.
            contacts: Those at the start, which do not count either.
        """
        self.goals = tuple(goals)
        self._links, self._carried, self._may_touch = links, carried, may_touch
        self._known = frozenset(map(_pair, contacts))

    @property
    def is_over(self) -> bool:
        """Whether every goal has ended."""
        return all(goal.status.is_terminal for goal in self.goals)

    def unexpected(self, contacts: Collection[Contact]) -> str:
        """Return what touches and should not; empty if nothing does."""
        for contact in contacts:
            pair = _pair(contact)
            is_ours = not pair.isdisjoint(self._links | self._carried)
            is_allowed = pair in self._known or not pair.isdisjoint(self._may_touch)
            is_grip = not pair.isdisjoint(self._carried) and pair <= (
                self._links | self._carried
            )
            if is_ours and not is_allowed and not is_grip:
                return contacts_text([(contact.first, contact.second)])
        return ""

    def fail(self, reason: str) -> None:
        """Let the goals end as aborted, with a reason, when they are cancelled."""

        def explained(result: Result) -> Result:
            if not isinstance(result, GoalResult):
                return result
            text = f"stopped: {reason}, which the plan does not expect"
            return replace(result, status=GoalStatus.ABORTED, error_string=text)

        for goal in self.goals:
            goal.explain = explained


def _pair(contact: Contact) -> frozenset[str]:
    return frozenset((contact.first, contact.second))
