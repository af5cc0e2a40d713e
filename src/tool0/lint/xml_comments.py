"""Comments in XML that need not be well-formed, found in one pass."""

from __future__ import annotations

import re
from collections.abc import Iterator

_OPEN, _CLOSE = "<!--", "-->"
_NOT_LINE_ENDS = re.compile(r"[^\n]")


def comments(text: str) -> Iterator[tuple[int, int]]:
    """Yield where each comment begins and ends; one that is not closed is none."""
    end = 0
    while (start := text.find(_OPEN, end)) >= 0:
        close = text.find(_CLOSE, start + len(_OPEN))
        if close < 0:
            return
        end = close + len(_CLOSE)
        yield start, end


def inside(text: str, start: int, end: int) -> str:
    """Return what a comment says."""
    return text[start + len(_OPEN) : end - len(_CLOSE)]


def without_comments(text: str) -> str:
    """Return ``text`` with blanks for its comments: places stay what they are."""
    parts, before = [], 0
    for start, end in comments(text):
        parts += [text[before:start], blank(text[start:end])]
        before = end
    return "".join([*parts, text[before:]])


def blank(text: str) -> str:
    """Return ``text`` as white space of the same length and lines."""
    return _NOT_LINE_ENDS.sub(" ", text)
