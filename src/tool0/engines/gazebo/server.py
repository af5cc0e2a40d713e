"""Start, logs, crashes and shutdown of the processes gzserver and gzclient."""

from __future__ import annotations

import contextlib
import logging
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Final, final

from tool0.engines.gazebo.connection import BridgeConnection, BridgeListener
from tool0.errors import EngineUnavailableError
from tool0.installation.child_process import ChildProcess
from tool0.installation.gazebo.installation import GazeboInstallation
from tool0.installation.gazebo.plugin import BridgeLibraries
from tool0.user_data import locked

logger = logging.getLogger(__name__)

START_TIMEOUT = 30.0
"""Timeout for gzserver to load the bridge [s].  Loading takes 10 s if the disk cache is
empty."""
_EXIT_TIMEOUT: Final = 0.2
"""Timeout for a disconnected server to exit without a signal [wall s]."""
_FOLDER: Final = "tool0-gazebo-"
_LOCK: Final = "lock"
_NEW_LOCK: Final = "lock.new"
_MAX_STARTS: Final = 3
_DELIBERATE: Final = (0, -signal.SIGTERM, -signal.SIGINT, -signal.SIGKILL)
"""Exit statuses of a gzclient process that the user has closed."""
_LAST_LINES: Final = 12
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
_NOISE: Final = re.compile(
    r"$|Gazebo multi-robot simulator|Copyright|Released under|http://gazebosim"
    # The render engine draws nothing without a display.
    r"|\[Msg\]|\[\w+\] \[RenderEngine"
    # libsdformat prints this line before it tries to parse SDF.
    r"|Error:\s+Could not find the 'robot'"
)
"""Pattern of lines that every gzserver prints and that never explain a failure."""
_ERROR: Final = re.compile(r"\[Err\]|Error|\[Wrn\] \[Server")


def _window_program(installation: GazeboInstallation) -> Path:
    """Return the path of gzclient, or raise EngineUnavailableError."""
    if installation.client is None:
        raise EngineUnavailableError(
            "this Gazebo has no gzclient; run `tool0 gazebo install --gui`"
        )
    if not os.environ.get("DISPLAY"):
        raise EngineUnavailableError(
            "gzclient needs an X display, and DISPLAY is not set; "
            "omit --gazebo-gui, or use the panel"
        )
    return installation.client


_PORTS = range(12000, 32000)
"""Ports for gzserver, which are below the ports that Linux assigns to outgoing
connections."""


@final
class GazeboServer:
    """One gzserver process with a separate folder, port and HOME.

    The server exits when ``close`` is called, or when this process exits for any
    reason.
    """

    def __init__(
        self,
        installation: GazeboInstallation,
        libraries: BridgeLibraries,
        world: Path,
        *,
        gui: bool,
        renders: bool,
    ) -> None:
        """Start gzserver with ``world`` and the bridge; ``open_window`` needs ``gui``.

        If ``renders`` is set, gzserver can render, which its sensors need.  If
        ``renders`` is not set, gzserver gets no display, because an X error while
        loading OGRE would block gzserver.

        Raises:
            EngineUnavailableError: If a window is requested and cannot be opened.
        """
        self._client = _window_program(installation) if gui else None
        self._installation = installation
        self._preload = str(libraries.preload)
        self._port = _free_port()
        self._lines_read = 0
        self._window: ClientWindow | None = None
        with contextlib.ExitStack() as exits:
            self.folder = exits.enter_context(_own_folder())
            self._log = self.folder / "gzserver.log"
            self._listener = BridgeListener(self.folder / "bridge")
            exits.callback(self._listener.close)
            # Without gzclient, ``~/physics/contacts`` is not published.  Publishing
            # this topic in each step takes a tenth of the time, even without
            # subscribers.
            quiet = () if gui else ("--minimal_comms",)
            bridge = str(libraries.bridge)
            self._process = self._run(
                installation.server,
                ["--verbose", *quiet, "-s", bridge, str(world)],
                self._log,
                {
                    # The path is relative to the folder in which gzserver runs.
                    "TOOL0_BRIDGE": "bridge",
                    **({} if renders else {"DISPLAY": ""}),
                },
            )
            self._exits = exits.pop_all()

    @property
    def master_uri(self) -> str:
        """Value of ``GAZEBO_MASTER_URI`` for the command ``gz`` and for plugins."""
        return f"http://127.0.0.1:{self._port}"

    @property
    def process_ids(self) -> tuple[int, ...]:
        """Process ids of the running processes."""
        window = [] if self._window is None else [self._window.process]
        running = (p for p in (self._process, *window) if p.exit_status is None)
        return tuple(process.pid for process in running)

    def connect(self, dt: float) -> BridgeConnection:
        """Return the connection to the bridge, for steps of ``dt`` [s].

        Raises:
            EngineUnavailableError: If gzserver does not start, or if the bridge has
                another version.
        """
        peer = self._listener.accept(dt, self._check, START_TIMEOUT)
        self._listener.close()
        return BridgeConnection(peer, self._lost)

    def open_window(self) -> None:
        """Start gzclient for this server, if ``gui`` was set."""
        client, log = self._client, self.folder / "gzclient.log"
        if client is not None:
            # The user's HOME is used, so that the window has the user's settings.
            home = os.environ.get("HOME", str(self.folder))
            self._window = ClientWindow(
                lambda: self._run(client, ["--verbose"], log, {"HOME": home}), log
            )

    def new_errors(self) -> list[str]:
        """Return the errors that the server has logged since the last call."""
        lines = _log_lines(self._log)
        new, self._lines_read = lines[self._lines_read :], len(lines)
        return [line for line in new if _ERROR.match(line)]

    def close(self) -> None:
        """End the processes and remove the folder; closing twice is allowed."""
        if self._window is not None:
            self._window.close()
        self._process.close()  # the process must exit before its folder is removed
        self._exits.close()

    def _check(self) -> None:
        """Raise EngineUnavailableError if the server has ended."""
        if self._process.exit_status is not None:
            raise EngineUnavailableError(
                _exit_report("gzserver did not start", self._process, self._log)
            )

    def _lost(self, why: str) -> EngineUnavailableError:
        """Release the resources of a server that has exited, and return an error."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_EXIT_TIMEOUT)
        error = EngineUnavailableError(_exit_report(why, self._process, self._log))
        self.close()
        return error

    def _run(
        self, program: Path, arguments: list[str], log: Path, extra: Mapping[str, str]
    ) -> ChildProcess:
        preload = [self._preload, os.environ.get("LD_PRELOAD", "")]
        environment = {
            **os.environ,
            **self._installation.environment,
            "HOME": str(self.folder),
            "GAZEBO_MASTER_URI": self.master_uri,
            "GAZEBO_IP": "127.0.0.1",
            "IGN_IP": "127.0.0.1",
            # With another value, gzserver would wait for the network.
            "GAZEBO_MODEL_DATABASE_URI": "",
            "LD_PRELOAD": ":".join(filter(None, preload)),
            **extra,
        }
        with log.open("wb") as stream:
            return ChildProcess(
                [str(program), *arguments],
                environment=environment,
                folder=self.folder,
                log=stream,
            )


@final
class ClientWindow:
    """A gzclient process, which is restarted if it crashes.

    On two busy cores with software GL, about one in 30 starts of gzclient 11 fails with
    a segmentation fault.
    """

    def __init__(self, run: Callable[[], ChildProcess], log: Path) -> None:
        """Start gzclient by calling ``run``; its output is written to ``log``."""
        self._run = run
        self._log = log
        self._lock = threading.Lock()
        self._is_closed = False
        self.process = run()
        watch = threading.Thread(target=self._watch, name="gzclient", daemon=True)
        watch.start()

    def close(self) -> None:
        """End gzclient; closing twice is allowed."""
        with self._lock:
            self._is_closed = True
            self.process.close()

    def _watch(self) -> None:
        for tries_left in reversed(range(_MAX_STARTS)):
            status = self.process.wait()
            with self._lock:
                if self._is_closed or status in _DELIBERATE:
                    return
                if status != -signal.SIGSEGV or not tries_left:
                    end = "Gazebo's window is gone"
                    logger.warning("%s", _exit_report(end, self.process, self._log))
                    return
                self.process.close()
                self.process = self._run()


@contextlib.contextmanager
def _own_folder() -> Iterator[Path]:
    """Create a temporary folder, and remove the folders of killed processes."""
    parent = Path(tempfile.gettempdir())
    for left in parent.glob(f"{_FOLDER}*/{_LOCK}"):
        # The folder of a running server is locked.  The folder of a server that is
        # starting does not contain a lock file yet.
        with contextlib.suppress(OSError), locked(left, wait=False):
            shutil.rmtree(left.parent, ignore_errors=True)
    folder = Path(tempfile.mkdtemp(prefix=_FOLDER))
    with locked(folder / _NEW_LOCK):
        (folder / _NEW_LOCK).rename(folder / _LOCK)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def _free_port() -> int:
    """Return a free port that outgoing connections cannot use."""
    while True:
        port = random.choice(_PORTS)  # several servers may start at the same time
        with (
            socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe,
            contextlib.suppress(OSError),
        ):
            probe.bind(("", port))  # gzserver binds the port on all addresses
            return port


def _exit_report(why: str, process: ChildProcess, log: Path) -> str:
    """Return ``why``, the exit status of ``process``, and the end of its log."""
    status = process.exit_status
    if status is None:
        how = ""
    elif status < 0:
        how = f", killed by {signal.Signals(-status).name}"
    else:
        how = f", exit status {status}"
    lines = "".join(f"\n  {line}" for line in _log_lines(log)[-_LAST_LINES:])
    end = f"; the end of its log:{lines}" if lines else "; its log is empty"
    return f"{why}{how}{end}"


def _log_lines(log: Path) -> list[str]:
    """Return a log's lines that do not match ``_NOISE``, without color codes."""
    try:
        text = log.read_text(errors="replace")
    except OSError:
        return []
    lines = (line.rstrip() for line in _COLOUR.sub("", text).splitlines())
    return [line for line in lines if not _NOISE.match(line)]
