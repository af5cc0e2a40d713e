"""Token processing between lexer and parser: new lines, nesting and unclosed blocks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, final

from lark import Token
from lark.lark import PostLex

from tool0.ur.urscript_errors import Place, URScriptError

MAX_NESTING: Final = 100
"""Maximum depth of nested blocks and brackets, and maximum number of consecutive
signs."""
_CLOSERS: Final = {"_CLOSE": "(", "RSQB": "["}
_OPENERS: Final = {"_OPEN": ")", "LIST_OPEN": "]"}
_BLOCKS: Final = ("IF", "WHILE", "DEFINE")
_INFIX: Final = frozenset(
    {"OR", "XOR", "AND", "NOT", "COMPARE", "EQUAL", "SIGN", "FACTOR", "COMMA"}
)
"""Tokens after which a statement continues on the next line."""
_LAST: Final = frozenset(
    {"NAME", "INTEGER", "FLOAT", "STRING", "TRUE", "FALSE", "_CLOSE", "RSQB"}
)
_FIRST: Final = frozenset(
    {"NAME", "SCOPE", "DEFINE", "IF", "WHILE", "RETURN", "KILL", "JOIN", "RUN"}
    | {"BREAK", "CONTINUE", "HALT", "PAUSE", "ENTER_CRITICAL", "EXIT_CRITICAL"}
)
"""Tokens that start another statement on the same line if they follow a token of
``_LAST``."""


@final
class Layout(PostLex):
    """Keeps the new lines that end statements and adds missing new lines.

    Inside brackets and after an operator, a statement continues on the next line.
    """

    always_accept = ()

    def process(self, stream: Iterator[Token]) -> Iterator[Token]:
        """Yield the tokens, with one new line after each statement and block header."""
        opened: list[Token] = []
        in_brackets = signs = 0
        is_fresh = True
        n_tokens = 0  # in this statement
        last: Token | None = None
        askew: Token | None = None  # start of a block with an 'end' that is not aligned
        for token in stream:
            kind = token.type
            if kind == "_NL":
                is_open = last is not None and last.type in _INFIX
                if not in_brackets and not is_fresh and not is_open:
                    is_fresh = True
                    yield token
                continue
            is_inside = not is_fresh and not in_brackets and n_tokens > 1
            if is_inside and _begins_another(last, token):
                is_fresh = True
                yield _new_line(token)
            signs = signs + 1 if kind in {"SIGN", "NOT"} else 0
            if kind in _CLOSERS:
                _close(opened, token)
                in_brackets -= 1
            elif kind in {"_END", "_ELIF", "_ELSE"}:
                if in_brackets:
                    raise _unclosed(opened[-1])
                if not opened:
                    raise _at(token, f"'{token}' without a block that it could end")
                if kind == "_END":
                    opener = opened.pop()
                    if askew is None and not _is_aligned(opener, token):
                        askew = opener
                elif opened[-1].type != "IF":
                    raise _at(token, f"'{token}' without an 'if'")
                if not is_fresh:
                    yield _new_line(token)
            elif kind in _OPENERS:
                opened.append(token)
                in_brackets += 1
            elif kind in _BLOCKS:
                if in_brackets:
                    raise _unclosed(opened[-1])
                opened.append(token)
            if max(len(opened), signs) > MAX_NESTING:
                raise _at(token, f"nested deeper than {MAX_NESTING} levels")
            yield token
            last, n_tokens = token, 1 if is_fresh else n_tokens + 1
            is_fresh = False
            if kind in {"_COLON", "_END"} and not in_brackets:
                is_fresh = True
                yield _new_line(token)
        if opened:
            is_block = opened[-1].type in _BLOCKS
            raise _unclosed(askew if askew and is_block else opened[-1])
        if last is not None and not is_fresh:
            yield _new_line(last)


def _begins_another(last: Token | None, token: Token) -> bool:
    return last is not None and last.type in _LAST and token.type in _FIRST


def _new_line(beside: Token) -> Token:
    return Token.new_borrow_pos("_NL", "\n", beside)


def _is_aligned(opener: Token, end: Token) -> bool:
    """Return whether ``end`` is in the column or the line in which its block starts."""
    return opener.line == end.line or opener.column == end.column


def _close(opened: list[Token], token: Token) -> None:
    if not opened or opened[-1].type in _BLOCKS:
        raise _at(token, f"'{token}' without '{_CLOSERS[token.type]}'")
    if opened[-1] != _CLOSERS[token.type]:
        raise _at(token, f"'{token}' does not close {_named(opened[-1])}")
    opened.pop()


def _named(opener: Token) -> str:
    return f"the '{opener}' of line {opener.line}, column {opener.column}"


def _unclosed(opener: Token) -> URScriptError:
    missing = _OPENERS.get(opener.type, "end")
    return _at(opener, f"'{opener}' has no '{missing}'")


def _at(token: Token, message: str) -> URScriptError:
    return URScriptError(message, Place(token.line or 1, token.column or 1))
