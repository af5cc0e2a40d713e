"""Compiles program texts to programs that can run."""

from __future__ import annotations

import asyncio
from functools import lru_cache
from typing import TYPE_CHECKING, Final

from tool0.ur.programs import RunnableProgram

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

KEPT: Final = 8
"""Maximum number of compiled programs in the cache."""


async def compiled(text: str, name: str) -> RunnableProgram[UrControlBox]:
    """Compile a program in another thread, because compiling may take some time.

    The program that ur_rtde uploads is recognized and executed natively.

    Raises:
        Tool0Error: If the program is not valid; the message contains the line and the
            column.
    """
    return await asyncio.to_thread(_compile, text, name)


def _compile(text: str, name: str) -> RunnableProgram[UrControlBox]:
    from tool0.ur.rtde_control.program import recognise

    known = recognise(text)
    if known is not None:
        return known
    return _compiled(text, name)


@lru_cache(maxsize=KEPT)
def _compiled(text: str, name: str) -> RunnableProgram[UrControlBox]:
    """Return a program from the cache; clients often send the same program again."""
    from tool0.ur.urscript.program import compile_program

    return compile_program(text, name)


def prepare() -> None:
    """Import the compiler and build its parser in advance, which takes about 0.3 s."""
    from tool0.ur.urscript.program import compile_program

    compile_program("sleep(0.0)", "nothing")
