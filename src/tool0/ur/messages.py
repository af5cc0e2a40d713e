"""Messages from a control box to the clients of its primary interface."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from datetime import datetime, timezone
from enum import Enum
from typing import Final, NamedTuple, final

from tool0.ur.urscript_errors import URScriptError

MAX_LOG: Final = 10_000
"""Maximum number of messages in the log; older messages are discarded."""


class MessageKind(Enum):
    """Kinds of messages that are sent on UR's primary interface."""

    TEXT = "text"
    """Text of ``textmsg``."""
    POPUP = "popup"
    ERROR = "error"
    """Error of the robot, or error of a program that has no location."""
    EXCEPTION = "exception"
    """Exception of a program, with its location in the program's text."""
    PROGRAM = "program"
    """Name of the program that is running; empty when the program has ended."""


class Message(NamedTuple):
    """A message to all clients."""

    kind: MessageKind
    text: str
    title: str = ""
    """Title of the popup."""
    code: int = 0
    """UR's number for the error; 0 if the error has no number."""
    is_warning: bool = False
    """Whether the error is a warning, after which the arm can continue."""
    place: tuple[int, int] = (1, 1)
    """Line and column of the exception."""


@final
class Messages:
    """Passes messages to listeners in the event loop."""

    def __init__(self) -> None:
        self.listeners: set[Callable[[Message], None]] = set()
        self.popup: Message | None = None
        """Popup that is shown; None if there is no popup."""
        self.log: deque[str] = deque(maxlen=MAX_LOG)
        """Lines of the log; each line contains a message's wall time, kind and text."""

    def text(self, text: str) -> None:
        """Send a line from ``textmsg``."""
        self._send(Message(MessageKind.TEXT, text))

    def error(self, text: str, code: int = 0, *, is_warning: bool = False) -> None:
        """Send an error with UR's error number."""
        self._send(Message(MessageKind.ERROR, text, code=code, is_warning=is_warning))

    def exception(self, error: URScriptError) -> None:
        """Send a program's error, with UR's wording if clients depend on it."""
        if error.key:
            self.text(error.message)
        text = error.key or error.message
        place = error.line, error.column
        self._send(Message(MessageKind.EXCEPTION, text, place=place))

    def program(self, name: str) -> None:
        """Send the name of the running program; empty if no program is running."""
        self._send(Message(MessageKind.PROGRAM, name))

    def show_popup(self, text: str, title: str) -> None:
        """Show a popup and replace the previous popup."""
        self.popup = Message(MessageKind.POPUP, text, title)
        self._send(self.popup)

    def close_popup(self) -> None:
        """Remove the popup, if there is one."""
        self.popup = None

    def note(self, text: str, kind: str = "note") -> None:
        """Add a line to the log, without sending a message."""
        now = datetime.now(timezone.utc).isoformat(timespec="milliseconds")
        self.log.append(f"{now} {kind}: {' '.join(text.split())}")

    def _send(self, message: Message) -> None:
        self.note(f"{message.title} {message.text}", message.kind.value)
        for listener in tuple(self.listeners):
            listener(message)
