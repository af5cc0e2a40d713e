"""Parses a URScript program to a syntax tree; errors contain their location."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, cast

from tool0.ur.urscript import syntax
from tool0.ur.urscript.grammar import parser
from tool0.ur.urscript_errors import Place, URScriptError

if TYPE_CHECKING:
    from lark import Token

MAX_SIZE: Final = 1_000_000
"""Maximum size of a program [characters]."""
_SHOWN: Final = 30
_NEVER: Final = {
    "for": "URScript has no 'for'; count in a 'while'",
    "switch": "URScript has no 'switch'; use 'if' and 'elif'",
    "case": "URScript has no 'case'; use 'if' and 'elif'",
    "import": "'import' is not supported: a program is one text",
    "class": "URScript has no classes",
    "try": "URScript has no exceptions",
}
_KEYWORDS: Final = frozenset(
    {
        *("and", "break", "continue", "def", "elif", "else", "end", "enter_critical"),
        *("exit_critical", "global", "halt", "if", "join", "kill", "local", "not"),
        *("or", "pause", "return", "run", "sec", "thread", "while", "xor"),
    }
)
_CHARACTERS: Final = {
    "'": 'strings are written with double quotes: "text"',
    '"': "this string has no closing quote on its line",
    "&": "write 'and' in place of '&'",
    "|": "write 'or' in place of '|'",
    "^": "write pow(base, exponent) in place of '^'",
    ";": "statements are separated by new lines, not by ';'",
    "{": "blocks start with ':' and end with 'end'; there are no braces",
    "}": "blocks start with ':' and end with 'end'; there are no braces",
}
_WORDS: Final = {
    "_COLON": "':'",
    "_CLOSE": "')'",
    "RSQB": "']'",
    "NAME": "a name",
    "EQUAL": "'='",
    "_OPEN": "'('",
}


def parse(text: str, name: str) -> syntax.Block:
    """Return the statements of a program.

    Args:
        text: The program; lines end with LF, CRLF or CR.
        name: Name of the program, for error messages.

    Raises:
        URScriptError: If the text is not a valid program; the error contains the line
            and the column.
    """
    if len(text) > MAX_SIZE:
        message = f"the program has {len(text)} characters; at most {MAX_SIZE} are read"
        raise URScriptError(message, Place(1, 1), name)
    from lark import UnexpectedCharacters, UnexpectedInput, UnexpectedToken
    from lark.exceptions import VisitError

    text = text.replace("\r\n", "\n").replace("\r", "\n")
    try:
        return cast("syntax.Block", parser().parse(text))
    except URScriptError as error:
        place = Place(error.line, error.column)
        raise URScriptError(error.message, place, name) from None
    except VisitError as error:  # lark's wrapper of errors in ``trees``
        cause = error.orig_exc
        if not isinstance(cause, URScriptError):
            raise
        place = Place(cause.line, cause.column)
        raise URScriptError(cause.message, place, name) from None
    except UnexpectedCharacters as error:
        place = Place(error.line, error.column)
        raise URScriptError(_about_character(error.char), place, name) from None
    except UnexpectedToken as error:
        token: Token = error.token
        place = Place(token.line or 1, token.column or 1)
        message, place = _about_token(token, error.accepts, text, place)
        raise URScriptError(message, place, name) from None
    except UnexpectedInput as error:
        place = Place(max(error.line, 1), max(error.column, 1))
        raise URScriptError("this is not URScript", place, name) from None


def _about_character(char: str) -> str:
    return _CHARACTERS.get(char, f"unexpected character {char!r}")


def _about_token(
    token: Token, accepted: set[str], text: str, place: Place
) -> tuple[str, Place]:
    """Return the problem at a token, and the location that a reader would expect."""
    line = text.split("\n")[place.line - 1]
    before = line[: place.column - 1]
    previous = re.search(r"(\w+)\W*$", before)
    for word in (str(token), previous.group(1) if previous else ""):
        if word in _NEVER:
            start = re.search(rf"\b{word}\b", line)
            column = start.start() + 1 if start else place.column
            return _NEVER[word], Place(place.line, column)
    if token == "=" and re.search(r"[-+*/%]\s*$", before):
        operator = before.rstrip()[-1]
        return f"'{operator}=' is not supported; write x = x {operator} …", place
    if token == "if" and previous and previous.group(1) == "else":
        return "write 'elif' in place of 'else if'", place
    if token == "=" and previous and previous.group(1) in _KEYWORDS:
        return f"'{previous.group(1)}' is a keyword, not a variable", place
    if token == "=":
        return "'=' assigns a value; use '==' to compare", place
    found = "end of the line" if token.type == "_NL" else f"'{token[:_SHOWN]}'"
    if token.type == "$END":
        found = "end of the program"
    wanted = [words for kind, words in _WORDS.items() if kind in accepted]
    if len(accepted) > len(wanted) and "NAME" in accepted:
        wanted = ["a value"]
    expected = f"; expected {' or '.join(wanted)}" if wanted else ""
    if token.type == "_NL" and token != "\n":
        place = Place(place.line, place.column + 1)
    return f"unexpected {found}{expected}", place
