"""Reading typed values out of a mapping of YAML, with errors that name the line."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from tool0.description.yaml_tree import Entry
from tool0.errors import ConfigError, SourceLocation, nearest_name


@final
@dataclass(frozen=True, slots=True)
class Namespace:
    """A mapping of values; every getter raises ConfigError with file and line."""

    entry: Entry

    @property
    def location(self) -> SourceLocation:
        return self.entry.location

    @property
    def name(self) -> str:
        """The last part of its key."""
        return self.entry.key.rpartition("/")[2]

    def find(self, path: str) -> Entry | None:
        """Return what stands at ``a/b``, or None."""
        entry: Entry | None = self.entry
        for part in path.split("/"):
            if entry is None or entry.children is None:
                return None
            entry = entry.children.get(part)
        return entry

    def namespace(self, path: str) -> Namespace | None:
        """Return the mapping at ``path``, or None if there is nothing."""
        entry = self.find(path)
        if entry is None:
            return None
        if entry.children is None:
            raise wrong(entry, "a mapping")
        return Namespace(entry)

    def names(self) -> Iterator[str]:
        """Yield the keys."""
        yield from self.entry.children or ()

    def number(self, path: str, default: float | None = None) -> float:
        """Return the finite number at ``path``."""
        entry = self.find(path)
        if entry is None:
            if default is None:
                raise self.missing(path, "a number")
            return default
        value = entry.scalar
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise wrong(entry, "a number")
        if not math.isfinite(value):
            raise wrong(entry, "a finite number")
        return float(value)

    def not_negative(self, path: str, default: float | None = None) -> float:
        """Return the number at ``path``, 0 or more."""
        value = self.number(path, default)
        entry = self.find(path)
        if entry is not None and not value >= 0.0:
            raise wrong(entry, "0 or more")
        return value

    def boolean(self, path: str, default: bool) -> bool:
        entry = self.find(path)
        if entry is None:
            return default
        if not isinstance(entry.scalar, bool):
            raise wrong(entry, "true or false")
        return entry.scalar

    def text(self, path: str) -> str:
        entry = self.find(path)
        if entry is None:
            raise self.missing(path, "a text")
        if not isinstance(entry.scalar, str):
            raise wrong(entry, "a text")
        return entry.scalar

    def texts(self, path: str) -> tuple[str, ...]:
        """Return the list of texts at ``path``, with at least one element."""
        entry = self.find(path)
        if entry is None:
            raise self.missing(path, "a list of names")
        texts = tuple(
            item.scalar for item in entry.items or () if isinstance(item.scalar, str)
        )
        if not texts or len(texts) != len(entry.items or ()):
            raise wrong(entry, "a list of names, like [joint_1, joint_2]")
        return texts

    def missing(self, path: str, kind: str) -> ConfigError:
        """Return the error that ``path`` must be there."""
        near = nearest_name(path, list(self.names())) if list(self.names()) else ""
        hint = near if near.startswith("; did") else ""
        return ConfigError(
            f"'{self.entry.key}' lacks '{path}', {kind}{hint}", self.location
        )


def wrong(entry: Entry, wanted: str) -> ConfigError:
    """Return the error that ``entry`` is not what is ``wanted``."""
    hint = ""
    text = entry.scalar
    if isinstance(text, str) and wanted == "a number":
        with contextlib.suppress(ValueError):
            hint = f"; YAML 1.1 writes that {float(text):.1e}"
    return ConfigError(
        f"'{entry.key}' must be {wanted}, got {entry.describe()}{hint}",
        entry.location,
    )
