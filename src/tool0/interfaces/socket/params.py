"""The parameters of one request, checked as they are taken."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn, final

from tool0.description.transform import Vector3
from tool0.errors import TransportError, did_you_mean


@final
class Params:
    """What a peer sent: every value is checked, and none may be left over."""

    def __init__(self, method: str, raw: object) -> None:
        if raw is None:
            raw = {}
        if not isinstance(raw, dict):
            raise TransportError(f"{method}: params must be an object, got {raw!r:.80}")
        self._method = method
        self._raw: dict[str, Any] = raw  # Any: the peer decides
        self._known: set[str] = set()

    def text(self, key: str) -> str:
        value = self._take(key)
        return value if isinstance(value, str) else self._refuse(key, value, "a string")

    def optional_text(self, key: str) -> str | None:
        return None if self._take(key, None) is None else self.text(key)

    def flag(self, key: str, default: bool) -> bool:
        value = self._take(key, default)
        return value if isinstance(value, bool) else self._refuse(key, value, "a bool")

    def count(self, key: str, default: int) -> int:
        value = self._take(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            self._refuse(key, value, "a whole number, 1 or more")
        return int(value)

    def number(self, key: str, *default: float) -> float:
        return self._number(key, self._take(key, *default))

    def optional_number(self, key: str) -> float | None:
        value = self._take(key, None)
        return None if value is None else self._number(key, value)

    def names(self, key: str) -> tuple[str, ...]:
        value = self._take(key, [])
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            self._refuse(key, value, "a list of strings")
        return tuple(value)

    def optional_names(self, key: str) -> tuple[str, ...] | None:
        return None if self._take(key, None) is None else self.names(key)

    def numbers(self, key: str) -> tuple[float, ...]:
        value = self._take(key, [])
        if not isinstance(value, list):
            self._refuse(key, value, "a list of numbers")
        return tuple(self._number(key, item) for item in value)

    def optional_numbers(self, key: str) -> tuple[float, ...] | None:
        return None if self._take(key, None) is None else self.numbers(key)

    def vector(self, key: str, *default: Vector3) -> Vector3:
        value = self._take(key, *default)
        if not isinstance(value, (list, tuple)) or len(value) != 3:
            self._refuse(key, value, "a list of three numbers")
        x, y, z = (self._number(key, item) for item in value)
        return x, y, z

    def number_by_name(self, key: str) -> Mapping[str, float] | None:
        value = self._take(key, None)
        if value is None:
            return None
        if not isinstance(value, dict):
            self._refuse(key, value, "an object of numbers")
        return {name: self._number(key, item) for name, item in value.items()}

    def objects(self, key: str) -> tuple[Params, ...]:
        value = self._take(key, [])
        if not isinstance(value, list):
            self._refuse(key, value, "a list of objects")
        return tuple(
            Params(f"{self._method} {key}[{index}]", item)
            for index, item in enumerate(value)
        )

    def finish(self) -> None:
        """Raise TransportError if the peer sent a key that nothing reads."""
        for key in self._raw:
            if key not in self._known:
                hint = did_you_mean(key, self._known)
                raise TransportError(f"{self._method}: unknown parameter '{key}'{hint}")

    def _take(self, key: str, *default: object) -> Any:
        self._known.add(key)
        if key not in self._raw and not default:
            raise TransportError(f"{self._method}: parameter '{key}' is missing")
        return self._raw.get(key, *default)

    def _number(self, key: str, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            self._refuse(key, value, "a number")
        try:
            return float(value)
        except OverflowError:
            self._refuse(key, value, "a number that a float can hold")

    def _refuse(self, key: str, value: object, wanted: str) -> NoReturn:
        raise TransportError(
            f"{self._method}: '{key}' must be {wanted}, got {value!r:.80}"
        )
