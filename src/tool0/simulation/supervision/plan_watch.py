"""Detection of unexpected contacts during planned motions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import final

from tool0.description.model import RobotModel
from tool0.description.scene_state import Contact, contacts_text
from tool0.protocol.goals import Goal, GoalResult, GoalStatus, Result


@final
class ContactWatch:
    """Finds contacts that are not expected during a planned motion."""

    def __init__(
        self,
        links: frozenset[str],
        contacts: Collection[Contact],
        *,
        carried: frozenset[str],
        may_touch: frozenset[str] = frozenset(),
    ) -> None:
        """Monitor a motion that begins now.

        Args:
            links: Links that the motion moves.
            contacts: Contacts at the start, which are ignored.  The contacts of the
                first check are also ignored, because an engine may record contacts only
                after the first request.
            carried: Names of the objects that move with the links.  Carried objects and
                links may touch each other.
            may_touch: Names of the links and objects with contacts that are ignored.
        """
        self._links, self._carried, self._may_touch = links, carried, may_touch
        self._known = set(map(_pair, contacts))
        self._has_looked = False

    def unexpected(self, contacts: Collection[Contact]) -> str:
        """Describe an unexpected contact in a sentence.

        The result is empty if there is no unexpected contact.
        """
        if not self._has_looked:
            self._has_looked = True
            self._known.update(map(_pair, contacts))
        for contact in contacts:
            pair = _pair(contact)
            is_ours = not pair.isdisjoint(self._links | self._carried)
            is_allowed = pair in self._known or not pair.isdisjoint(self._may_touch)
            is_grip = not pair.isdisjoint(self._carried) and pair <= (
                self._links | self._carried
            )
            if is_ours and not is_allowed and not is_grip:
                text = contacts_text([(contact.first, contact.second)])
                return f"stopped: {text}, which the plan does not expect"
        return ""


@final
class PlanWatch:
    """Monitors the goals of one planned motion."""

    def __init__(self, goals: Sequence[Goal], contacts: ContactWatch) -> None:
        """Monitor the ``goals`` of the controllers that follow the motion."""
        self.goals = tuple(goals)
        self.contacts = contacts

    @property
    def is_over(self) -> bool:
        """Whether every goal has ended."""
        return all(goal.status.is_terminal for goal in self.goals)

    def fail(self, reason: str) -> None:
        """Mark canceled goals as aborted, with a reason."""

        def explained(result: Result) -> Result:
            if not isinstance(result, GoalResult):
                return result
            return replace(result, status=GoalStatus.ABORTED, error_string=reason)

        for goal in self.goals:
            goal.explain = explained


def links_moved_by(model: RobotModel, joints: Iterable[str]) -> frozenset[str]:
    """Return all links that ``joints`` move."""
    return frozenset(
        link for name in joints for link in model.links_from(model.joint(name).child)
    )


def _pair(contact: Contact) -> frozenset[str]:
    return frozenset((contact.first, contact.second))
