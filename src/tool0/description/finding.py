"""Findings: mistakes in a user's file, each with its location and a remedy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Literal, TypedDict, final

from tool0.errors import SourceLocation

_LONGEST = 100
_MOST_QUOTED = 8

Severity = Literal["error", "warning"]
"""Severity of a finding.  An error causes a failure or an unintended effect; a warning
reports a suspicious entry."""


class FindingJson(TypedDict):
    """A finding as a dict of plain values."""

    file: str | None
    """File of the mistake."""
    line: int | None
    """Line number, counted from 1."""
    severity: Severity
    """``error`` for a failure or an unintended effect; ``warning`` for a suspicious
    entry."""
    rule: str
    """Identifier of the kind of mistake, such as ``unread-key``."""
    key: str
    """Subject of the finding, such as a parameter's full name, an element or a
    joint."""
    message: str
    """Description of the problem and of its effect."""
    remedy: str
    """Instruction for fixing the mistake; empty if the message is sufficient."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One mistake in a user's file."""

    location: SourceLocation
    """File and line of the mistake."""
    rule: str
    """Identifier of the kind of mistake, such as ``unread-key``."""
    severity: Severity = "error"
    """``error`` for a failure or an unintended effect; ``warning`` for a suspicious
    entry."""
    key: str = ""
    """Subject of the finding, such as a parameter's full name, an element or a
    joint."""
    message: str
    """Description of the problem and of its effect."""
    remedy: str = ""
    """Instruction for fixing the mistake; empty if the message is sufficient."""

    @property
    def text(self) -> str:
        """The problem and the remedy as one text: ``message; remedy``."""
        return "; ".join(part for part in (self.message, self.remedy) if part)

    def as_json(self) -> FindingJson:
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
    """Return a finding, by default an error; ``Finding`` describes the fields."""
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
    """Return the first ``names`` as text for a message: ``'a', 'b' and 3 more``."""
    items = [f"'{short(name)}'" for name in names]
    left_out = len(items) - _MOST_QUOTED
    more = f" and {left_out} more" if left_out > 0 else ""
    return ", ".join(items[:_MOST_QUOTED]) + more


def short(text: str) -> str:
    """Return ``text``, with its middle part omitted if it is too long for a message."""
    if len(text) <= _LONGEST:
        return text
    half = _LONGEST // 2 - 1
    return f"{text[:half]}…{text[-half:]}"
