"""What the fixtures of the conformance suite are."""

from __future__ import annotations

from typing import Protocol

import tool0


class BringUp(Protocol):
    """Bring a robot up on the engine under test, as ``tool0.bringup`` does."""

    def __call__(self, **options: object) -> tool0.Robot: ...
