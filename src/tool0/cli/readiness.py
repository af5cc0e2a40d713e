"""What ``status`` commands print: what a machine has of something, and lacks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Literal, Protocol

from tool0.cli.text import columns

OK, IMPOSSIBLE = 0, 1


class Readiness(Protocol):
    """Whether something could run here, and what is missing."""

    @property
    def can_run(self) -> bool: ...

    def as_json(self) -> dict[str, object]: ...

    def rows(self) -> Sequence[Sequence[str]]: ...


def tell(found: Readiness, format: Literal["text", "json"]) -> int:
    """Print it, for people or for programs; return the exit status."""
    if format == "json":
        print(json.dumps(found.as_json()))
    else:
        print(columns(found.rows()), end="")
    return OK if found.can_run else IMPOSSIBLE
