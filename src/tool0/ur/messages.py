"""Messages of a control box to the clients of its primary interface."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from datetime import datetime, timezone
from enum import Enum
from typing import Final, NamedTuple, final

from tool0.ur.urscript_errors import URScriptError

MAX_LOG: Final = 10_000
"""Messages in the log; older ones are forgotten."""


class MessageKind(Enum):
    """The messages of UR's primary interface that occur."""

    TEXT = "text"
    """Text of ``textmsg``."""
    POPUP = "popup"
    ERROR = "error"
    """Error of the robot, or of a program as a whole."""
    EXCEPTION = "exception"
    """Exception of a program, at a place in its text."""
    PROGRAM = "program"
    """The name of the program that runs now; empty when it has ended."""


class Message(NamedTuple):
    """A message to every client."""

    kind: MessageKind
    text: str
    title: str = ""
    """Title of a popup."""
    code: int = 0
    """Number of an error, as UR numbers them; 0 for those that it does not have."""
    is_warning: bool = False
    """Whether an error is one that the arm can go on after."""
    place: tuple[int, int] = (1, 1)
    """Line and column of an exception."""


@final
class Messages:
    """Passes messages on to listeners, in the event loop."""

    def __init__(self) -> None:
        self.listeners: set[Callable[[Message], None]] = set()
        self.popup: Message | None = None
        """The popup that is shown."""
        self.log: deque[str] = deque(maxlen=MAX_LOG)
        """The messages as lines: wall time, kind and text."""

    def text(self, text: str) -> None:
        """Send a line of ``textmsg``."""
        self._send(Message(MessageKind.TEXT, text))

    def error(self, text: str, code: int = 0, *, is_warning: bool = False) -> None:
        """Send an error, with UR's number for it."""
        self._send(Message(MessageKind.ERROR, text, code=code, is_warning=is_warning))

    def exception(self, error: URScriptError) -> None:
        """Send an error of a program; clients know some by UR's words for them."""
        if error.key:
            self.text(error.message)
        text = error.key or error.message
        place = error.line, error.column
        self._send(Message(MessageKind.EXCEPTION, text, place=place))

    def program(self, name: str) -> None:
        """Tell which program runs now."""
        self._send(Message(MessageKind.PROGRAM, name))

    def show_popup(self, text: str, title: str) -> None:
        """Show a popup, in place of the one that is shown."""
        self.popup = Message(MessageKind.POPUP, text, title)
        self._send(self.popup)

    def close_popup(self) -> None:
        """Remove the popup, if there is one."""
        self.popup = None

    def note(self, text: str, kind: str = "note") -> None:
        """Add a line to the log, without a message."""
        now = datetime.now(timezone.utc).isoformat(timespec="milliseconds")
        self.log.append(f"{now} {kind}: {' '.join(text.split())}")

    def _send(self, message: Message) -> None:
        self.note(f"{message.title} {message.text}", message.kind.value)
        for listener in tuple(self.listeners):
            listener(message)
