"""The state of launch at one moment: configurations, namespace and remaps."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import final

from tool0.errors import SourceLocation
from tool0.lint.launch.load_context import LoadContext
from tool0.lint.launch.model import Condition, Place, Statement, Text, all_hold
from tool0.lint.launch.python.values import Value


@final
@dataclass(slots=True, kw_only=True)
class LaunchState:
    """State of launch, which a file shares with the files that it includes."""

    context: LoadContext
    configurations: dict[str, Text] = field(default_factory=dict)
    """Values of launch configurations.  A configuration without a value has an
    unresolved text."""
    uses: dict[str, SourceLocation] = field(default_factory=dict)
    """Launch configurations that are used in any file, with the place of a use."""
    parameters: dict[str, Value] = field(default_factory=dict)
    """Parameters that ``SetParameter`` sets for all later nodes."""
    namespace: str | None = "/"
    remaps: tuple[Statement, ...] = ()
    environment: tuple[Statement, ...] = ()
    conditions: tuple[Condition, ...] = ()
    unread: list[str] = field(default_factory=list)
    """Actions that could not be read.  Each of these actions may have changed any part
    of the state."""

    @property
    def holds(self) -> bool | None:
        """Whether the current action is executed; None if this is unknown."""
        return all_hold(self.conditions)

    def place(self, location: SourceLocation) -> Place:
        """Return the place of the action that is being processed."""
        return Place(
            location=location, namespace=self.namespace, conditions=self.conditions
        )

    def if_active(self, text: Text) -> Text:
        """Return a text.

        The text has no value if the action depends on an unknown condition.
        """
        if self.holds is not None:
            return text
        return replace(text, resolved=None, reason="it depends on a condition")

    def scoped(self) -> LaunchState:
        """Return the state in a group.  Settings in the group end with the group."""
        return replace(
            self,
            configurations=dict(self.configurations),
            parameters=dict(self.parameters),
        )

    def under(self, *conditions: Condition) -> LaunchState:
        """Return the state of actions that have additional conditions."""
        return replace(self, conditions=(*self.conditions, *conditions))
