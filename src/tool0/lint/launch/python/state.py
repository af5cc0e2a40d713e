"""The state of launch at one moment: configurations, namespace, remaps."""

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
    """Context of launch, shared by a file and the files that it includes."""

    context: LoadContext
    configurations: dict[str, Text] = field(default_factory=dict)
    """Values of LaunchConfigurations; those without a value are unresolved."""
    uses: dict[str, SourceLocation] = field(default_factory=dict)
    """Configurations that are used in any file."""
    parameters: dict[str, Value] = field(default_factory=dict)
    """Parameters that SetParameter sets for all later nodes."""
    namespace: str | None = "/"
    remaps: tuple[Statement, ...] = ()
    environment: tuple[Statement, ...] = ()
    conditions: tuple[Condition, ...] = ()
    unread: list[str] = field(default_factory=list)
    """Actions so far that could not be read, and may have set anything."""

    @property
    def holds(self) -> bool | None:
        """Whether the current action is executed; None if unknown."""
        return all_hold(self.conditions)

    def place(self, location: SourceLocation) -> Place:
        """Return the place of an action that is being executed."""
        return Place(
            location=location, namespace=self.namespace, conditions=self.conditions
        )

    def if_active(self, text: Text) -> Text:
        """Return a text, without a value if a condition may keep it from being set."""
        if self.holds is not None:
            return text
        return replace(text, resolved=None, reason="it depends on a condition")

    def scoped(self) -> LaunchState:
        """Return the state in a group; settings made in it end with the group."""
        return replace(
            self,
            configurations=dict(self.configurations),
            parameters=dict(self.parameters),
        )

    def under(self, *conditions: Condition) -> LaunchState:
        """Return the state of actions under further conditions."""
        return replace(self, conditions=(*self.conditions, *conditions))
