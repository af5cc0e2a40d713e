"""From the text of a program to one that can run."""

from __future__ import annotations

import asyncio

from tool0.interfaces.ur.programs import Program


async def compiled(text: str, name: str) -> Program:
    """Return a program; its text is read in another thread, as that takes a while.

    The program that ur_rtde uploads is recognised and executed natively.

    Raises:
        URScriptError: If it is not valid, with line and column.
    """
    from tool0.interfaces.ur.rtde_control.program import recognise

    known = recognise(text)
    if known is not None:
        return known
    from tool0.interfaces.ur.urscript.program import compile_program

    return await asyncio.to_thread(compile_program, text, name)
