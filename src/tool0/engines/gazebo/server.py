"""A gzserver of our own, and its gzclient: started, watched, ended."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final, final

from tool0.engines.gazebo.process_log import error_lines, exit_report, log_lines
from tool0.engines.gazebo.window import ClientWindow, require_window
from tool0.errors import EngineUnavailableError
from tool0.installation.child_process import ChildProcess
from tool0.installation.gazebo.installation import GazeboInstallation
from tool0.installation.gazebo.plugin import BridgeLibraries
from tool0.user_data import locked

_EXIT_TIMEOUT: Final = 0.2
"""For a server that closed the connection to end by itself [wall s]."""
_FOLDER: Final = "tool0-gazebo-"
_LOCK: Final = "lock"
_NEW_LOCK: Final = "lock.new"


@final
class GazeboServer:
    """One gzserver with its own folder, its own port and its own HOME.

    It ends with ``close``, and with this process however that ends.
    """

    def __init__(
        self, installation: GazeboInstallation, libraries: BridgeLibraries
    ) -> None:
        """Make the folder; ``start`` runs something in it."""
        self._installation = installation
        self._libraries = libraries
        self._exits = contextlib.ExitStack()
        self.folder = self._exits.enter_context(_own_folder())
        self._log = self.folder / "gzserver.log"
        self._lines_read = 0
        self._port = _free_port()
        self._server: ChildProcess | None = None
        self._window: ClientWindow | None = None

    @property
    def socket_path(self) -> Path:
        """Where the bridge is awaited."""
        return self.folder / "bridge"

    @property
    def master_uri(self) -> str:
        """What ``GAZEBO_MASTER_URI`` has to be for `gz` and for plugins."""
        return f"http://127.0.0.1:{self._port}"

    @property
    def process_ids(self) -> tuple[int, ...]:
        """Of the programs that run."""
        processes = (self._server, self._window and self._window.process)
        running = (p for p in processes if p is not None and p.exit_status is None)
        return tuple(process.pid for process in running)

    def start(self, world: Path, *, has_window: bool) -> None:
        """Run gzserver with ``world`` and the bridge.

        Without a gzclient of ours, ``~/physics/contacts`` stays empty: publishing it at
        each step takes a tenth of the time.
        """
        quiet = () if has_window else ("--minimal_comms",)
        bridge = str(self._libraries.bridge)
        self._server = self._run(
            self._installation.server,
            ["--verbose", *quiet, "-s", bridge, str(world)],
            self._log,
            {"TOOL0_BRIDGE": self.socket_path.name},  # it runs in the folder,
        )

    def open_window(self) -> None:
        """Run gzclient on the server.

        Raises:
            EngineUnavailableError: If it is not installed or there is no display.
        """
        client = require_window(self._installation)
        # The person's own HOME, so that settings of the window persist.
        home = os.environ.get("HOME", str(self.folder))
        log = self.folder / "gzclient.log"
        self._window = ClientWindow(
            lambda: self._run(client, ["--verbose"], log, {"HOME": home}), log
        )

    def check(self) -> None:
        """Raise EngineUnavailableError if the server has ended."""
        if self._server is None or self._server.exit_status is not None:
            raise EngineUnavailableError(
                exit_report("gzserver did not start", self._server, self._log)
            )

    def new_errors(self) -> list[str]:
        """Return the errors in the server's log since the last call."""
        lines = log_lines(self._log)
        new, self._lines_read = lines[self._lines_read :], len(lines)
        return error_lines(new)

    def lost(self, why: str) -> EngineUnavailableError:
        """End what is left of the server, and return the error that says so."""
        if self._server is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._server.wait(_EXIT_TIMEOUT)
        error = EngineUnavailableError(exit_report(why, self._server, self._log))
        self.close()
        return error

    def close(self) -> None:
        """End both processes and remove the folder; closing twice is allowed."""
        if self._window is not None:
            self._window.close()
        if self._server is not None:
            self._server.close()  # before its folder is removed
        self._exits.close()

    def _run(
        self, program: Path, arguments: list[str], log: Path, extra: Mapping[str, str]
    ) -> ChildProcess:
        preload = [str(self._libraries.preload), os.environ.get("LD_PRELOAD", "")]
        environment = {
            **os.environ,
            **self._installation.environment,
            "HOME": str(self.folder),
            "GAZEBO_MASTER_URI": self.master_uri,
            "GAZEBO_IP": "127.0.0.1",
            "IGN_IP": "127.0.0.1",
            "GAZEBO_MODEL_DATABASE_URI": "",  # or it waits for the network
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


@contextlib.contextmanager
def _own_folder() -> Iterator[Path]:
    """Make a folder that is removed at the end; remove those of killed processes."""
    parent = Path(tempfile.gettempdir())
    for left in parent.glob(f"{_FOLDER}*/{_LOCK}"):
        # That of a running server is locked, and a new one has no lock yet.
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
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
