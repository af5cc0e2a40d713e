"""The XML and YAML that a text shows, at the lines where they stand."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, final
from xml.parsers import expat

_NUMBER = re.compile(r"^\s*\d{1,4}(?=\s+<)")
"""A line number that was copied with the line."""
_XML = re.compile(r"^\s*<(?:\?xml|!--|[A-Za-z_])")
_YAML_START = re.compile(r"^\s*[A-Za-z_/][\w/]*: *(?:#.*|&\w+ *)?$")
_YAML = re.compile(r"^\s*(?:#.*|- .*|\"?[A-Za-z_/][\w/]*\"? *:(?: .*)?|[}\]],?)?$")
_LONGEST = 2000
"""[lines] of one snippet."""
_MOST_READ = 300_000
"""[lines] that are tried in one text, those of which nothing came counted."""


@final
@dataclass(frozen=True, slots=True)
class Snippet:
    """Lines of a text that are XML or YAML."""

    kind: Literal["xml", "yaml"]
    row: int
    """Of its first line, from 0."""
    text: str


def snippets(text: str) -> Iterator[Snippet]:
    """Yield the XML fragments and the YAML of a text, in order."""
    lines = text.splitlines()
    row = n_read = 0
    while row < len(lines):
        kind: Literal["xml", "yaml"] = "xml"
        n_rows = 0
        if _XML.match(_NUMBER.sub("", lines[row])) and n_read < _MOST_READ:
            n_rows, n_tried = _xml_rows(lines[row : row + _LONGEST])
            n_read += n_tried
        if not n_rows and _YAML_START.match(lines[row]):
            kind, n_rows = "yaml", _yaml_rows(lines[row : row + _LONGEST])
        if not n_rows:
            row += 1
            continue
        part = lines[row : row + n_rows]
        if kind == "xml":
            part = [_NUMBER.sub("", line) for line in part]
        yield Snippet(kind, row, textwrap.dedent("\n".join(part)) + "\n")
        row += n_rows


def _xml_rows(lines: list[str]) -> tuple[int, int]:
    """Return how many lines from the first on are a well-formed fragment.

    With it comes how many were read to find that out.
    """
    depth, is_comment, rows, number = 0, False, 0, 0

    def start(*_: object) -> None:
        nonlocal depth
        depth += 1

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.Parse("<fragment>", False)
    for number, numbered in enumerate(lines):
        line = _NUMBER.sub("", numbered)
        outside = depth == 1 and not is_comment
        if outside and line.strip() and not _XML.match(line):
            break
        if line.lstrip().startswith("<?xml"):
            if number:
                break
            continue
        try:
            parser.Parse(f"{line}\n", False)
        except expat.ExpatError:
            break
        opened, closed = line.rfind("<!--"), line.rfind("-->")
        is_comment = opened > closed or (is_comment and closed < 0)
        if depth == 1 and not is_comment and line.rstrip().endswith(">"):
            rows = number + 1
    return rows, number + 1


def _yaml_rows(lines: list[str]) -> int:
    """Return how many lines from the first on may be one YAML."""
    rows = blank = 0
    for number, line in enumerate(lines):
        blank = 0 if line.strip() else blank + 1
        if blank > 1 or not _YAML.match(line):
            break
        if line.strip():
            rows = number + 1
    return rows
