"""One thing that a machine has, or lacks."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal, final

State = Literal["ready", "missing", "not supported", "unknown"]
"""Unknown is what the probe for it could not find out."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """What ``tool0 doctor`` tells of one thing."""

    what: str
    state: State
    found: str
    """Its version and where it is; or what is missing, and what for."""
    remedy: str = ""
    """The command that installs what is missing; empty if nothing has to be done."""

    def as_json(self) -> dict[str, str]:
        """Return what JSON can hold; ``Line(**line.as_json())`` is the line again."""
        return asdict(self)
