"""Guessing which name was meant, within bounds that no input can stretch."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable

_MOST_NAMES = 500
_LONGEST = 100
_MOST_QUOTED = 8


def nearest(name: str, valid: Collection[str], cutoff: float = 0.6) -> str | None:
    """Return the valid name most like ``name``, or None.

    A name that differs by a prefix alone comes first: ``tool0`` means ``left_tool0``.
    """
    if not name or len(name) > _LONGEST or len(valid) > _MOST_NAMES:
        return None
    names = sorted(item for item in valid if 0 < len(item) <= _LONGEST)
    prefixed = [
        item for item in names if item.endswith(f"_{name}") or name.endswith(f"_{item}")
    ]
    if len(prefixed) == 1:
        return prefixed[0]
    close = difflib.get_close_matches(name, names, n=1, cutoff=cutoff)
    return close[0] if close else None


def quoted(names: Iterable[str]) -> str:
    """Return some of ``names`` for a sentence: ``'a', 'b' and 3 more``."""
    items = [f"'{short(name)}'" for name in names]
    left_out = len(items) - _MOST_QUOTED
    more = f" and {left_out} more" if left_out > 0 else ""
    return ", ".join(items[:_MOST_QUOTED]) + more


def short(text: str) -> str:
    """Return ``text`` without its middle if it is too long for a sentence."""
    if len(text) <= _LONGEST:
        return text
    half = _LONGEST // 2 - 1
    return f"{text[:half]}…{text[-half:]}"
