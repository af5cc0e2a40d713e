"""Functions for time, messages and the interpreter mode."""

from __future__ import annotations

from typing import Final

from tool0.ur.urscript.code import Site
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import AnyValue, Bool, Number, Text
from tool0.ur.urscript.values import Value, checked_struct, to_text
from tool0.ur.urscript_errors import ValueProblem

_MESSAGE: Final = 25
"""Number of statements that are charged for a message, so that clients can keep up."""


async def sleep(thread: Thread, t: Number) -> None:
    """Wait for a duration in simulated time [s]."""
    if t < 0.0:
        raise ValueProblem(f"the time is {t}, less than 0")
    await thread.pacer.wait(t)


async def sync(thread: Thread) -> None:
    """Wait for the next control period of the robot."""
    await thread.pacer.wait(1.0 / thread.box.rate)


def get_steptime(thread: Thread) -> float:
    """Return the control period [s]."""
    return 1.0 / thread.box.rate


def time(thread: Thread) -> Value:
    """Return the simulated time as a struct of seconds and remaining nanoseconds."""
    nanoseconds = round(thread.box.time * 1e9)
    return checked_struct(("sec", "nanosec"), divmod(nanoseconds, 10**9))


def _assert(condition: Bool) -> None:
    """End the program with an error if a condition does not hold."""
    if not condition:
        raise ValueProblem("the assertion does not hold")


def textmsg(thread: Thread, s1: AnyValue, s2: AnyValue = "") -> None:
    """Send text to the logs of all clients."""
    thread.left -= _MESSAGE
    thread.box.messages.text(shown(to_text(s1) + to_text(s2)))


async def popup(
    thread: Thread,
    s: AnyValue,
    title: Text = "Popup",
    warning: Bool = False,
    error: Bool = False,
    blocking: Bool = False,
) -> None:
    """Show a popup; a blocking popup also waits until it is closed."""
    del warning, error
    messages = thread.box.messages
    messages.show_popup(shown(to_text(s)), shown(title))
    popup = messages.popup
    while blocking and messages.popup is popup:
        await thread.box.next_update()


async def interpreter_mode(
    site: Site, clearQueueOnEnter: Bool = True, clearOnEnd: Bool = True
) -> None:
    """Execute statements of clients until end_interpreter() is called."""
    await site.frame.thread.execution.interpreter.run(
        site, clear_queue=clearQueueOnEnter, clear_on_end=clearOnEnd
    )


def end_interpreter(thread: Thread) -> None:
    """End interpreter_mode() after the current statement."""
    thread.execution.interpreter.end()


async def clear_interpreter(thread: Thread) -> None:
    """Remove all definitions and variables of interpreted statements."""
    await thread.execution.interpreter.clear()


def shown(text: str) -> str:
    """Convert a string with one character per byte to readable text."""
    return text.encode("latin-1", "replace").decode("utf-8", "replace")


FUNCTIONS: Final[tuple[Function, ...]] = (
    function(sleep, physical=True),
    function(sync, physical=True),
    function(interpreter_mode, physical=True),
    *(function(item) for item in (clear_interpreter, end_interpreter)),
    *(function(item) for item in (_assert, get_steptime, popup, textmsg, time)),
)
