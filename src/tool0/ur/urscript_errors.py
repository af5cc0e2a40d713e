"""Errors in a URScript program, with their places."""

from __future__ import annotations

from typing import NamedTuple, final

from tool0.errors import Tool0Error


class Place(NamedTuple):
    """A location in a program, counted from 1."""

    line: int
    column: int


@final
class URScriptError(Tool0Error):
    """A program that cannot be executed, or that failed while it was executed."""

    def __init__(
        self, message: str, place: Place, program: str = "program", key: str = ""
    ) -> None:
        """Report ``message`` as ``program:line:column: message``.

        Args:
            message: Description of the problem.
            place: Where.
            program: The name of its source.
            key: Name of this error on UR's controller; empty if that is not known.
        """
        super().__init__(f"{program}:{place.line}:{place.column}: {message}")
        self.message = message
        self.line, self.column = place
        self.program = program
        self.key = key


@final
class ValueProblem(Exception):  # noqa: N818 - becomes a URScriptError with its place
    """A value that an operator or a function does not accept; the place is added."""
