"""A launch file explained: a tree of items, for people and for programs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from tool0.errors import SourceLocation


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """Something in a launch file, and what is in it."""

    kind: str
    """``include``, ``node``, ``param``, ``argument``, ``use`` and so on."""
    name: str
    value: str | None = None
    """None if it has none, or none that is known."""
    location: SourceLocation
    note: str = ""
    """What else is to be said: why it has no value, why it is switched off."""
    items: tuple[Item, ...] = ()
