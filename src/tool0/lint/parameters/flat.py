"""Indentation that was lost, so that nested YAML reads as flat."""

from __future__ import annotations

import re
from collections.abc import Iterator

from tool0.control.controller_types import TYPES
from tool0.control.parameter_tables import GAINS, LIMITS, parameters_of
from tool0.description.finding import Finding
from tool0.errors import SourceLocation

_KEY = re.compile(r"^( *)([\w/.*-]+) *:(?: *| +[&!]\S+ *)(?:#.*)?$")
"""A key with nothing after it."""
_ANY = re.compile(r"^( *)([\w/.*-]+) *:")
_INSIDE = (
    GAINS
    | LIMITS
    | {part.split("/")[0] for name in TYPES for part in parameters_of(name)}
    | {"type", "pid_gains", "trajectory", "goal", "goal_time"}
    | {"ros__parameters", "command_interfaces", "state_interfaces"}
) - {"*"}
"""Keys that stand below another one, never at the top."""


def flat_findings(text: str, first: SourceLocation) -> Iterator[Finding]:
    """Yield a finding if keys stand beside the one that they belong below.

    Args:
        text: The YAML, which need not be correct.
        first: Where its first line stands.
    """
    found = list(_flat_keys(text))
    if not found:
        return
    row, key, inside = found[0]
    others = len(found) - 1
    more = f" ({others} more like it below)" if others else ""
    yield Finding(
        location=SourceLocation(first.file, (first.line or 1) + row),
        rule="flat-yaml",
        key=key,
        message=f"is empty, since '{inside}' after it is not indented: its parameters "
        f"are set beside it, where nothing reads them{more}",
        remedy=f"indent what belongs to '{key}' by two spaces",
    )


def restored(text: str) -> str:
    """Return a flat YAML with the indentation that it seems to have lost."""
    flat = {row for row, _, _ in _flat_keys(text)}
    around: list[int] = []  # the indents of the keys that lines are moved below
    lines = []
    for row, line in enumerate(text.splitlines()):
        match = _ANY.match(line)
        if match is not None:
            indent = len(match[1])
            while around and (
                indent < around[-1]
                or (indent == around[-1] and match[2] not in _INSIDE)
            ):
                around.pop()
        lines.append("  " * len(around) + line)
        if row in flat and match is not None:
            around.append(len(match[1]))
    return "\n".join(lines) + "\n"


def _flat_keys(text: str) -> Iterator[tuple[int, str, str]]:
    """Yield row, key and the next one, of keys that lost what is below them."""
    empty: tuple[int, str, str] | None = None
    for row, line in enumerate(text.splitlines()):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if empty is not None and (match := _ANY.match(line)) is not None:
            before, indent, key = empty
            if match[1] == indent and match[2] in _INSIDE and key not in _INSIDE:
                yield before, key, match[2]
        match = _KEY.match(line)
        empty = None if match is None else (row, match[1], match[2])
