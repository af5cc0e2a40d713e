"""Gazebo's own window: gzclient."""

from __future__ import annotations

import logging
import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Final, final

from tool0.engines.gazebo.process_log import exit_report
from tool0.errors import EngineUnavailableError
from tool0.installation.child_process import ChildProcess
from tool0.installation.gazebo.installation import GazeboInstallation

logger = logging.getLogger(__name__)

_MAX_STARTS: Final = 3
_CLOSED_BY_PERSON: Final = (0, -signal.SIGTERM, -signal.SIGINT, -signal.SIGKILL)
"""Exit statuses when somebody closes it."""


def require_window(installation: GazeboInstallation) -> Path:
    """Return the program gzclient, or raise EngineUnavailableError."""
    if installation.client is None:
        raise EngineUnavailableError(
            "this Gazebo has no gzclient; run `tool0 gazebo install --gui`"
        )
    if not os.environ.get("DISPLAY"):
        raise EngineUnavailableError(
            "gzclient needs an X display, and DISPLAY is not set; "
            "leave out the Gazebo GUI, or use the panel"
        )
    return installation.client


@final
class ClientWindow:
    """A gzclient, started again if it crashes.

    gzclient 11 does so while it starts, by a segmentation fault, now and then: once in
    30 times on two busy cores, with software GL.
    """

    def __init__(self, run: Callable[[], ChildProcess], log: Path) -> None:
        """Start it by ``run``, which writes its output to ``log``."""
        self._run = run
        self._log = log
        self._lock = threading.Lock()
        self._is_closed = False
        self.process = run()
        watch = threading.Thread(target=self._watch, name="gzclient", daemon=True)
        watch.start()

    def close(self) -> None:
        """End it; closing twice is allowed."""
        with self._lock:
            self._is_closed = True
            self.process.close()

    def _watch(self) -> None:
        for tries_left in reversed(range(_MAX_STARTS)):
            status = self.process.wait()
            with self._lock:
                if self._is_closed or status in _CLOSED_BY_PERSON:
                    return
                if status != -signal.SIGSEGV or not tries_left:
                    why = exit_report(
                        "Gazebo's window is gone", self.process, self._log
                    )
                    logger.warning("%s", why)
                    return
                self.process.close()
                self.process = self._run()
