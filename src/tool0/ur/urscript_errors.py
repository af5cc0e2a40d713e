"""Errors in a URScript program, with their locations."""

from __future__ import annotations

from typing import NamedTuple, final

from tool0.errors import Tool0Error


class Place(NamedTuple):
    """A location in a program; lines and columns start at 1."""

    line: int
    column: int


@final
class URScriptError(Tool0Error):
    """Raised if a program cannot be executed or fails during execution."""

    def __init__(
        self, message: str, place: Place, program: str = "program", key: str = ""
    ) -> None:
        """Create an error with the text ``program:line:column: message``.

        Args:
            message: Description of the problem.
            place: Location of the problem.
            program: Name of the program's source.
            key: Name of the error on UR's controller; empty if the name is unknown.
        """
        super().__init__(f"{program}:{place.line}:{place.column}: {message}")
        self.message = message
        self.line, self.column = place
        self.program = program
        self.key = key


@final
class ValueProblem(Exception):  # noqa: N818 - becomes a URScriptError with a location
    """Raised for a value that is invalid for an operator or function."""
