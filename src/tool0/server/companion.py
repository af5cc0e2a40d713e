"""A process that is started with a robot and restarted whenever it ends."""

from __future__ import annotations

import contextlib
import itertools
import json
import logging
import os
import re
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeVar

from tool0.errors import Tool0Error
from tool0.installation.child_process import ChildProcess, last_lines
from tool0.protocol.channel import backend_of

if TYPE_CHECKING:
    from tool0.protocol.channel import Connected

C = TypeVar("C", bound="Companion")

START_TIMEOUT: Final = 60.0
"""Longest wait until the process is ready [wall s]."""
FIRST_PAUSE: Final = 0.5
"""Pause before the first restart of the process [wall s].  The pause is doubled after
each restart."""
LONGEST_PAUSE: Final = 30.0
"""Longest pause before the process is restarted [wall s]."""
UNABLE: Final = 78
"""Exit status of a program with missing requirements, which is not restarted because it
would fail again."""
_GRACE: Final = 3.0
"""Time within which the process must end when it is stopped [wall s]."""
_LAST_LINES: Final = 12
_LINE = re.compile(r"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[[\d.]+\] (\[.*)")
_LEVELS: Final = {
    "DEBUG": logging.DEBUG,
    "INFO": logging.INFO,
    "WARN": logging.WARNING,
    "ERROR": logging.ERROR,
    "FATAL": logging.ERROR,
}
_numbers = itertools.count(1)


class Companion:
    """Program that provides an interface of a robot until the companion is closed.

    This class is a context manager.  The program is restarted when it ends, unless its
    exit status is ``UNABLE``.  The program reports that it is ready with the line
    ``{"ready": true, …}`` on its standard output.  Other lines are log messages in
    ROS's format: ``[WARN] [time] [name]: text``.
    """

    title: ClassVar[str]
    """Name of the interface for messages, such as ``ROS 2``."""
    kind: ClassVar[str]
    """Kind of the program for messages, such as ``node``."""
    unavailable: ClassVar[type[Tool0Error]]
    """Error class for a program that does not start."""

    def __init__(
        self,
        robot: Connected | str,
        command: Callable[[str], list[str]],
        environment: Mapping[str, str],
    ) -> None:
        """Start the program; ``_wait_for_report`` waits until it is ready.

        Args:
            robot: A robot of this process or another process, or the name of a
                bring-up, which may start later.  The caller closes the robot after the
                companion.
            command: Function that returns the program and its arguments for the name of
                a bring-up.
            environment: Environment variables of the program.
        """
        self._program = f"{self.title} {self.kind}"
        self._logger = logging.getLogger(type(self).__module__)
        self._environment = {**environment, "PYTHONUNBUFFERED": "1"}
        self._lines: deque[str] = deque(maxlen=_LAST_LINES)
        self._is_closing = threading.Event()
        self._changed = threading.Condition()
        self._report: Mapping[str, Any] | None = None
        self._failure: str | None = None
        self._child: ChildProcess | None = None
        with contextlib.ExitStack() as stack:
            label = self.title.replace(" ", "").lower()
            self._command = command(_served_name(robot, label, stack))
            self._service = stack.pop_all()
        self._thread = threading.Thread(
            target=self._supervise, name=f"tool0 {self.title}", daemon=True
        )
        self._thread.start()

    def __enter__(self: C) -> C:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def pid(self) -> int | None:
        """Process id of the program; None while it is not running."""
        child = self._child
        return None if child is None else child.pid

    def close(self) -> None:
        """End the program; further calls have no effect."""
        self._is_closing.set()
        child = self._child
        if child is not None:
            child.close()
        self._thread.join()
        self._service.close()

    def _wait_for_report(self, timeout: float) -> Mapping[str, Any]:
        """Wait until the program is ready, and return its report.

        Raises:
            Tool0Error: Raised as ``unavailable`` if the program does not start within
                ``timeout`` [wall s].
        """
        with self._changed:
            self._changed.wait_for(lambda: self._report or self._failure, timeout)
            if self._report is not None:
                return self._report
            why = self._failure or f"it is not up after {timeout:g} s"
        raise self.unavailable(f"the {self._program} did not start: {why}")

    # ---- in the companion's thread --------------------------------------------------

    def _supervise(self) -> None:
        """Run the program repeatedly until the companion is closed."""
        pause = FIRST_PAUSE
        while not self._is_closing.is_set():
            start = time.monotonic()
            status = self._run()
            if self._is_closing.is_set():
                return
            last = last_lines("\n".join(self._lines), _LAST_LINES)
            if self._report is None:
                with self._changed:
                    self._failure = f"it ended with status {status}.\n{last}"
                    self._changed.notify_all()
                return
            if status == UNABLE:
                self._logger.error(
                    "the %s ended and is not started again: %s",
                    self._program,
                    last.strip(),
                )
                return
            if time.monotonic() - start > LONGEST_PAUSE:
                pause = FIRST_PAUSE
            self._logger.warning(
                "the %s ended with status %s; it starts again in %g s%s",
                self._program,
                status,
                pause,
                f".  Its last output:\n{last}" if last else "",
            )
            self._is_closing.wait(pause)
            pause = min(2.0 * pause, LONGEST_PAUSE)

    def _run(self) -> int:
        """Run the program until it ends, and return its exit status."""
        self._lines.clear()
        ours, theirs = os.pipe()
        with open(ours, encoding="utf-8", errors="replace") as output:  # noqa: PTH123
            with open(theirs, "wb") as log:  # noqa: PTH123  # a descriptor
                child = ChildProcess(
                    self._command,
                    environment=self._environment,
                    log=log,
                    grace=_GRACE,
                )
            with child:
                self._child = child
                if self._is_closing.is_set():
                    return 0
                # If the program's supervisor is killed, the pipe stays open until this
                # thread ends the program.
                threading.Thread(target=child.wait, daemon=True).start()
                for line in output:
                    self._take(line.rstrip("\n"))
                status = child.wait()
        self._child = None
        return status

    def _take(self, line: str) -> None:
        """Handle a line of the program's output, which is a report or a log message."""
        if line.startswith("{"):
            with contextlib.suppress(ValueError):
                report = json.loads(line)
                if report.get("ready"):
                    with self._changed:
                        self._report = report
                        self._changed.notify_all()
                    return
        if not line.strip() or self._is_closing.is_set():
            return
        found = _LINE.match(line)
        if found is None:
            self._lines.append(line)
            self._logger.warning("%s: %s", self._program, line)
        else:
            level, text = found.groups()
            self._logger.log(_LEVELS[level], "%s %s", self.title, text)


def _served_name(
    robot: Connected | str, label: str, stack: contextlib.ExitStack
) -> str:
    """Return the name under which a robot is served; serve the robot if it is local.

    Args:
        robot: A robot of this process or another process, or the robot's name.
        label: Part of the name if a name has to be generated.
        stack: Exit stack to which the end of the service is added.
    """
    if isinstance(robot, str):
        return robot
    from tool0.protocol.socket_channel import SocketChannel

    if isinstance(robot.channel, SocketChannel):
        return robot.channel.name
    from tool0.protocol.address import Claim
    from tool0.server.server import Server, UnixSocketService

    claim = Claim(f"{label}-{os.getpid()}-{next(_numbers)}")
    stack.callback(claim.close)
    service = UnixSocketService(claim)
    stack.enter_context(Server(backend_of(robot.channel), [service], claim.name))
    return claim.name
