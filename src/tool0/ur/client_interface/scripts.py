"""Extraction of programs from the text that clients send.

A program is a block or a single line. A block starts with ``def`` or ``sec`` and ends
at the matching ``end``, including all nested blocks. Any other line is a separate
program. A line that only calls the preceding block is ignored, because the block has
already been started as a program. The text may be received in chunks of any size.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple, final

from tool0.errors import TransportError

MAX_PROGRAM: Final = 1 << 19
"""Maximum length of a program [bytes]. For comparison, ur_rtde's control program is 42
kB long."""
MAX_LINE: Final = 1 << 16
"""Maximum length of a line [bytes]."""
UNNAMED: Final = "unnamed"
"""Name that is used for a program that consists of a single line."""
_CODE: Final = re.compile(r"\"[^\"]*\"?|'[^']*'?|#.*|[^\W\d]\w*")
"""Pattern of the strings, comments and words in a line."""
_OPENING: Final = frozenset({"def", "sec", "thread", "if", "while", "for", "switch"})
_CALL: Final = re.compile(r"\s*(\w+)\(\s*\)\s*(?:#.*)?")
_HEAD: Final = re.compile(r"\s*(def|sec)\s+(\w+)")


class Script(NamedTuple):
    """A program that a client sent."""

    text: str
    name: str
    is_secondary: bool = False
    """Whether the program is secondary. A secondary program runs alongside the program
    that moves the arm."""


@final
class ScriptReader:
    """Assembles programs from the bytes of one connection."""

    def __init__(self) -> None:
        self._rest = bytearray()
        self._block: _Block | None = None
        self._last = ""
        """Name of the last complete block."""

    @property
    def unfinished(self) -> str:
        """Name of the block that has no ``end`` yet; empty if no block is open."""
        return "" if self._block is None else self._block.name

    def read(self, data: bytes) -> Iterator[Script]:
        """Yield the programs that ``data`` completes.

        Raises:
            TransportError: If a line or a program is too long.
        """
        searched = len(self._rest)
        self._rest += data
        start = 0
        while (end := self._rest.find(b"\n", max(start, searched))) >= 0:
            line = self._rest[start:end].decode(errors="replace").rstrip("\r")
            start = end + 1
            script = self._take(line)
            if script is not None:
                yield script
        del self._rest[:start]
        if len(self._rest) > MAX_LINE:
            raise TransportError(f"a line has more than {MAX_LINE} bytes")

    def _take(self, line: str) -> Script | None:
        """Return the program that a line completes, if there is one."""
        if self._block is None:
            if not line.strip() or line.lstrip().startswith("#"):
                return None
            head = _HEAD.match(line)
            if head is None:
                call = _CALL.fullmatch(line)
                if call is not None and call[1] == self._last:
                    return None
                return Script(f"{line}\n", UNNAMED)
            self._block = _Block(head[2], is_secondary=head[1] == "sec")
        script = self._block.take(line)
        if script is not None:
            self._block = None
            self._last = script.name
        return script


@final
class _Block:
    """The lines of a ``def`` or ``sec`` block that have been received."""

    def __init__(self, name: str, *, is_secondary: bool) -> None:
        self.name, self._is_secondary = name, is_secondary
        self._lines: list[str] = []
        self._size = self._depth = 0

    def take(self, line: str) -> Script | None:
        """Add a line; return the program if the line completes it."""
        self._lines.append(line)
        self._size += len(line) + 1
        if self._size > MAX_PROGRAM:
            raise TransportError(f"a program has more than {MAX_PROGRAM} bytes")
        words: list[str] = _CODE.findall(line)
        self._depth += sum(w in _OPENING for w in words) - words.count("end")
        if self._depth > 0:
            return None
        text = "\n".join((*self._lines, ""))
        return Script(text, self.name, self._is_secondary)
