"""Arms, grippers and cameras of a robot by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NoReturn, TypeVar, final

from tool0.errors import NoSuchPartError, did_you_mean

Part = TypeVar("Part")


@final
class Parts(dict[str, Part]):
    """Parts of one kind by name; the error for an unknown name suggests valid names."""

    def __init__(self, kind: str, parts: Mapping[str, Part]) -> None:
        super().__init__(parts)
        self._kind = kind

    def __missing__(self, name: str) -> NoReturn:
        hint = did_you_mean(str(name), list(self))
        raise NoSuchPartError(f"no {self._kind} '{name}'{hint}")
