"""What a launch file says: as written, and as roslaunch would read it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal, final

from tool0.errors import SourceLocation


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """An attribute's value, or the text of an element."""

    raw: str
    """As it is written."""
    resolved: str | None
    """With every ``$(…)`` replaced; None if one of them has no value here."""
    location: SourceLocation
    uses: tuple[str, ...] = ()
    """The names of the arguments in it, each once, of the file it is written in."""
    packages: tuple[str, ...] = ()
    """The packages that ``$(find …)`` in it asks for, each once."""
    reason: str = ""
    """Why it is not resolved."""


@final
class Activity(Enum):
    """Whether roslaunch would act on an element."""

    ACTIVE = "active"
    INACTIVE = "inactive"
    """Switched off by its ``if`` or ``unless``, or by those around it."""
    UNKNOWN = "unknown"
    """It depends on an argument without a value."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """An ``if`` or ``unless``."""

    kind: Literal["if", "unless"]
    text: Text
    holds: bool | None
    """Whether it lets the element be; None if that cannot be told."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where an element stands, and whether it counts."""

    location: SourceLocation
    namespace: str | None
    """Global, with a slash at its end; None if it cannot be resolved."""
    conditions: tuple[Condition, ...] = ()
    """Of this element and those around it, over all includes; the outermost first."""

    @property
    def activity(self) -> Activity:
        """Whether roslaunch would act on the element."""
        held = [condition.holds for condition in self.conditions]
        if False in held:
            return Activity.INACTIVE
        return Activity.UNKNOWN if None in held else Activity.ACTIVE
