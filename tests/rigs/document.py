"""A page of the documentation, as the blocks of code that it has."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

_BLOCK = re.compile(r"^( *)```([^\n]*)\n(.*?)^\1```$", re.DOTALL | re.MULTILINE)
_GAP = "…"
"""Stands for anything, in what a page says is printed."""


@dataclass(frozen=True)
class Block:
    language: str
    title: str
    """What follows the language: a file's name, or where its commands run."""
    text: str

    @property
    def is_output(self) -> bool:
        """Whether it is what the block before it prints."""
        return self.language == "text" and not self.title

    def commands(self) -> list[str]:
        """Return its commands; one that goes on in the next line is one text."""
        found, text = [], ""
        for line in self.text.replace("\\\n", " ").splitlines():
            text = f"{text}\n{line}" if text else line
            try:
                words = shlex.split(text, comments=True)
            except ValueError:  # within quotation marks
                continue
            found += [text] if words else []
            text = ""
        assert not text, f"a quotation without an end: {text}"
        return found


def blocks(page: Path) -> list[Block]:
    found = _BLOCK.findall(page.read_text(encoding="utf-8"))
    return [
        Block(language, title, re.sub(f"^{indent}", "", text, flags=re.MULTILINE))
        for indent, info, text in found
        for language, _, title in [info.partition(" ")]
    ]


def says(output: str, expected: str) -> bool:
    """Return whether the output has these lines, in this order, whatever is between."""
    lines = iter([" ".join(line.split()) for line in output.splitlines()])
    return all(
        any(_pattern(wanted).search(line) for line in lines)
        for wanted in expected.splitlines()
    )


def _pattern(line: str) -> re.Pattern[str]:
    parts = " ".join(line.split()).split(_GAP)
    return re.compile(".*".join(re.escape(part.strip()) for part in parts))
