"""Compiles programs from clients for execution on a control box."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

from tool0.ur.moves import Moves
from tool0.ur.urscript import syntax as s
from tool0.ur.urscript.checking import Checker
from tool0.ur.urscript.code import Code
from tool0.ur.urscript.compiling import Compiler
from tool0.ur.urscript.execution import Execution
from tool0.ur.urscript.interpreter import Interpreter
from tool0.ur.urscript.parsing import parse
from tool0.ur.urscript.scopes import program_scope
from tool0.ur.urscript_errors import Place, URScriptError

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox


@final
class URScriptProgram:
    """A checked and compiled program."""

    def __init__(self, code: Code, name: str) -> None:
        self._code = code
        self._source = name

    @property
    def name(self) -> str:
        """Name of the program's ``def``; for bare statements, the source's name."""
        return self._code.name

    @property
    def is_secondary(self) -> bool:
        """Whether the program is a ``sec``, which cannot move the arm."""
        return self._code.definition.kind == "sec"

    async def run(self, box: UrControlBox) -> None:
        """Run the program on a control box to its end.

        Raises:
            URScriptError: If the program fails; the error contains the location.
        """
        execution = Execution(
            self._source,
            box,
            Moves(box),
            is_secondary=self.is_secondary,
        )
        execution.interpreter = interpreter = Interpreter(execution)
        if self.is_secondary:
            await execution.run(self._code)
            return
        box.interpreter = interpreter
        try:
            await execution.run(self._code)
        finally:
            box.interpreter = None


def compile_program(text: str, name: str = "program") -> URScriptProgram:
    """Check and compile a program.

    A program is a ``def`` or a ``sec`` without parameters, or bare statements. If there
    are several definitions, the last one is the program, and it can call the other
    definitions. Compiling a long program takes time, so call this function outside the
    event loop's thread.

    Args:
        text: The program; lines end with LF, CRLF or CR.
        name: Name of the source, for error messages.

    Raises:
        URScriptError: If the program is invalid; the error contains line and column.
    """
    main = _main(parse(text, name), name)
    scope = program_scope(main)
    Checker(name, has_servers="rpc_factory" in text).check(scope)
    code = Compiler(name).compile(scope)
    return URScriptProgram(code, name)


def _main(statements: s.Block, name: str) -> s.Definition:
    if not statements:
        raise URScriptError("the program is empty", Place(1, 1), name)
    last = statements[-1]
    if not all(isinstance(item, s.Definition) for item in statements):
        return s.Definition(statements[0].at, "def", name, (), statements)
    assert isinstance(last, s.Definition)
    if last.kind == "thread":
        raise URScriptError("a 'thread' is part of a program", last.at, name)
    if last.parameters:
        raise URScriptError(
            f"'{last.name}' is the program: it has no parameters", last.at, name
        )
    others = statements[:-1]
    return s.Definition(last.at, last.kind, last.name, (), (*others, *last.body))
