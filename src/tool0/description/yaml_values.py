"""Typed access to the values of a YAML mapping, with errors that state the line."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, field
from typing import TypeVar, final

from tool0.description.transform import Vector3
from tool0.description.units import Quantity, read_number
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import ConfigError, SourceLocation, did_you_mean, nearest_name

Value = str | float | int | bool | tuple[str, ...] | tuple[float, ...]
"""Type of the values that the getters of ``Namespace`` return."""
Recorded = TypeVar("Recorded", bound=Value)


@final
@dataclass(slots=True)
class Reading:
    """Record of the keys read from a mapping and its nested mappings, by full key."""

    keys: set[str] = field(default_factory=set)
    """Keys that have been looked up."""
    values: dict[str, Value] = field(default_factory=dict)
    """Returned values by key, including defaults."""
    adjustable: set[str] = field(default_factory=set)
    """Keys of the values that may change while a controller runs."""


@final
@dataclass(frozen=True, slots=True)
class Namespace:
    """A mapping of values.

    Every getter raises ConfigError, with file and line, if its value is invalid.  The
    constructor raises ConfigError if ``entry`` is not a mapping.
    """

    entry: YamlEntry
    reading: Reading = field(default_factory=Reading)

    def __post_init__(self) -> None:
        if not self.entry.is_mapping:
            raise _wrong(self.entry, "a mapping")

    @property
    def location(self) -> SourceLocation:
        return self.entry.location

    @property
    def name(self) -> str:
        """Last part of the mapping's key."""
        return self.entry.key.rpartition("/")[2]

    def find(self, path: str) -> YamlEntry | None:
        """Return the entry at a path such as ``a/b``, or None."""
        self.reading.keys.add(f"{self.entry.key}/{path}")
        return self.entry.find(path)

    def namespace(self, path: str) -> Namespace | None:
        """Return the mapping at ``path``, or None if there is no such mapping."""
        entry = self.find(path)
        return None if entry is None else Namespace(entry, self.reading)

    def accept(self, *paths: str) -> None:
        """Mark as known the parameters that ROS reads and tool0 does not need."""
        self.reading.keys.update(f"{self.entry.key}/{path}" for path in paths)

    def mark_adjustable(self, *paths: str) -> None:
        """Mark parameters that may change while a controller runs."""
        self.reading.adjustable.update(f"{self.entry.key}/{path}" for path in paths)

    def read_keys(self) -> frozenset[str]:
        """Return the keys that were looked up, without their parent mappings."""
        keys = {self.path_of(key) for key in self.reading.keys}
        outer = {
            "/".join(parts[:n])
            for parts in (key.split("/") for key in keys)
            for n in range(1, len(parts))
        }
        return frozenset(keys - outer)

    def read_values(self) -> dict[str, Value]:
        """Return the values that the getters returned, including defaults, by path."""
        return {self.path_of(key): value for key, value in self.reading.values.items()}

    def adjustable_paths(self) -> frozenset[str]:
        """Return the paths that ``mark_adjustable`` marked."""
        return frozenset(map(self.path_of, self.reading.adjustable))

    def path_of(self, key: str) -> str:
        """Return the path, in this mapping, of the entry with the full key ``key``."""
        return key.removeprefix(f"{self.entry.key}/")

    def _recorded(self, path: str, value: Recorded) -> Recorded:
        self.reading.values[f"{self.entry.key}/{path}"] = value
        return value

    def only(self, *valid: str) -> None:
        """Raise ConfigError if there is a key that is not in ``valid``."""
        for name, entry in self.entry.children.items():
            if name not in valid:
                raise ConfigError(
                    f"unknown key '{entry.key}'{did_you_mean(name, valid)}",
                    entry.location,
                )

    def number(
        self, path: str, default: float | None = None, *quantities: Quantity
    ) -> float:
        """Return the finite number at ``path``, in SI units.

        If ``quantities`` are given, the number may have a unit of one of these
        quantities.
        """
        if default is not None and self.find(path) is None:
            return self._recorded(path, default)
        entry = self._required(path, "a number")
        return self._recorded(path, number_of(entry, *quantities))

    def integer(self, path: str, default: int) -> int:
        """Return the whole number at ``path``."""
        entry = self.find(path)
        if entry is None:
            return self._recorded(path, default)
        value = entry.scalar
        if isinstance(value, bool) or not isinstance(value, int):
            raise _wrong(entry, "a whole number")
        return self._recorded(path, value)

    def numbers(
        self,
        path: str,
        count: int,
        default: tuple[float, ...] | None = None,
        *quantities: Quantity,
    ) -> tuple[float, ...]:
        """Return the list of ``count`` finite numbers at ``path``; see ``number``."""
        if default is not None and self.find(path) is None:
            return self._recorded(path, default)
        kind = f"a list of {count} numbers"
        entry = self._required(path, kind)
        if len(entry.items) != count:
            raise _wrong(entry, kind)
        numbers = tuple(number_of(item, *quantities) for item in entry.items)
        return self._recorded(path, numbers)

    def vector(
        self, path: str, default: Vector3 | None = None, *quantities: Quantity
    ) -> Vector3:
        """Return the three numbers at ``path``; see ``number``."""
        x, y, z = self.numbers(path, 3, default, *quantities)
        return (x, y, z)

    def items(self, path: str) -> tuple[YamlEntry, ...]:
        """Return the elements of the list at ``path``; empty if there is no list."""
        entry = self.find(path)
        if entry is None or entry.is_null:
            return ()
        if not entry.is_list:
            raise _wrong(entry, "a list")
        return tuple(entry.items)

    def not_negative(self, path: str, default: float | None = None) -> float:
        """Return the number at ``path``, which must be 0 or more."""
        value = self.number(path, default)
        entry = self.find(path)
        if entry is not None and not value >= 0.0:
            raise _wrong(entry, "0 or more")
        return value

    def boolean(self, path: str, default: bool) -> bool:
        entry = self.find(path)
        if entry is None:
            return self._recorded(path, default)
        if not isinstance(entry.scalar, bool):
            raise _wrong(entry, "true or false")
        return self._recorded(path, entry.scalar)

    def text(self, path: str, default: str | None = None) -> str:
        """Return the string at ``path``."""
        if default is not None and self.find(path) is None:
            return self._recorded(path, default)
        entry = self._required(path, "a text")
        if not isinstance(entry.scalar, str):
            raise _wrong(entry, "a text")
        return self._recorded(path, entry.scalar)

    def texts(
        self, path: str, default: tuple[str, ...] | None = None
    ) -> tuple[str, ...]:
        """Return the list of strings at ``path``.

        If there is no default, the list must have at least one element.
        """
        found = self.find(path)
        if default is not None and found is None:
            return self._recorded(path, default)
        if default is not None and found is not None and found.value == []:
            return self._recorded(path, ())
        entry = self._required(path, "a list of names")
        texts = tuple(
            item.scalar for item in entry.items if isinstance(item.scalar, str)
        )
        if not texts or len(texts) != len(entry.items):
            raise _wrong(entry, "a list of names, like [joint_1, joint_2]")
        return self._recorded(path, texts)

    def _required(self, path: str, kind: str) -> YamlEntry:
        entry = self.find(path)
        if entry is not None:
            return entry
        near = nearest_name(path, self.entry.children)
        hint = f"; did you mean '{near}'?" if near else ""
        raise ConfigError(
            f"'{self.entry.key}' lacks '{path}', {kind}{hint}", self.location
        )


def number_of(entry: YamlEntry, *quantities: Quantity) -> float:
    """Return a finite number in SI units; its unit may be one of ``quantities``.

    Raises:
        ConfigError: If the value is not a finite number, or has another unit.  The
            error states the location of the value.
    """
    value = entry.scalar
    if quantities and value is not None and not isinstance(value, bool):
        try:
            return read_number(str(value), *quantities)[0]
        except ConfigError as error:
            raise ConfigError(f"'{entry.key}': {error}", entry.location) from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _wrong(entry, "a number")
    if not math.isfinite(value):
        raise _wrong(entry, "a finite number")
    return float(value)


def _wrong(entry: YamlEntry, wanted: str) -> ConfigError:
    hint = ""
    text = entry.scalar
    if isinstance(text, str) and wanted == "a number":
        with contextlib.suppress(ValueError):
            hint = f"; YAML 1.1 writes that {float(text):.1e}"
    return ConfigError(
        f"'{entry.key}' must be {wanted}, got {entry.describe()}{hint}",
        entry.location,
    )
