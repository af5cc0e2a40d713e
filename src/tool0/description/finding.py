"""Findings: mistakes in a user's file, with location and remedy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Literal, final

from tool0.errors import SourceLocation

_LONGEST = 100
_MOST_QUOTED = 8

Severity = Literal["error", "warning"]
"""Severity: an error fails or has an unintended effect; a warning is suspicious."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One mistake in a user's file."""

    location: SourceLocation
    """File and line of the mistake."""
    rule: str
    """Identifier of the kind of mistake, the same in every file, such as
    ``unread-key``."""
    severity: Severity = "error"
    """``error`` if it fails or has an unintended effect; ``warning`` if suspicious."""
    key: str = ""
    """Subject of the finding, such as a parameter's full name, an element or a
    joint."""
    message: str
    """Description of the problem, and why it matters."""
    remedy: str = ""
    """Remedy; empty if the message is sufficient."""

    @property
    def text(self) -> str:
        """Problem and remedy as one text: ``message; remedy``."""
        return "; ".join(part for part in (self.message, self.remedy) if part)

    def as_json(self) -> dict[str, str | int | None]:
        """Return the finding as a dict of plain values."""
        file = self.location.file
        return {
            "file": None if file is None else str(file),
            "line": self.location.line,
            "severity": self.severity,
            "rule": self.rule,
            "key": self.key,
            "message": self.message,
            "remedy": self.remedy,
        }

    def __str__(self) -> str:
        """Return ``file:line: key: message; remedy``."""
        text = ": ".join(part for part in (self.key, self.text) if part)
        return f"{self.location}: {text}"


def error_at(
    location: SourceLocation,
    rule: str,
    key: str,
    message: str,
    remedy: str = "",
    *,
    severity: Severity = "error",
) -> Finding:
    """Return a finding, an error by default; the arguments are those of ``Finding``."""
    return Finding(
        location=location,
        rule=rule,
        severity=severity,
        key=key,
        message=message,
        remedy=remedy,
    )


warning_at = partial(error_at, severity="warning")


def quoted(names: Iterable[str]) -> str:
    """Return the first ``names`` for a sentence, such as ``'a', 'b' and 3 more``."""
    items = [f"'{short(name)}'" for name in names]
    left_out = len(items) - _MOST_QUOTED
    more = f" and {left_out} more" if left_out > 0 else ""
    return ", ".join(items[:_MOST_QUOTED]) + more


def short(text: str) -> str:
    """Return ``text``; if it is too long for a sentence, its middle is omitted."""
    if len(text) <= _LONGEST:
        return text
    half = _LONGEST // 2 - 1
    return f"{text[:half]}…{text[-half:]}"
