"""Names in sentences, shortened to a bounded length."""

from __future__ import annotations

from collections.abc import Iterable

_LONGEST = 100
_MOST_QUOTED = 8


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
