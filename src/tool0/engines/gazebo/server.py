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
from tool0.installation.gazebo.installation import Installation
from tool0.installation.gazebo.plugin import BridgeLibraries
from tool0.user_data import locked

_GRACE = 0.2  # [s] for a server that hung up to end by itself
_FOLDER: Final = "tool0-gazebo-"
_LOCK: Final = "lock"
_NEW_LOCK: Final = "lock.new"


@final
class GazeboServer:
    """One gzserver with its own folder, its own port and its own HOME.

    It ends with ``close``, and with this process however that ends: the leash that is
    preloaded into it, and into gzclient, holds the other end of a pipe.
    """

    def __init__(self, installation: Installation, libraries: BridgeLibraries) -> None:
        """Make the folder; ``start`` runs something in it."""
        self._installation = installation
        self._libraries = libraries
        self._exits = contextlib.ExitStack()
        self.folder = self._exits.enter_context(_own_folder())
        self._log = self.folder / "gzserver.log"
        self._lines_read = 0
        self._port = _free_port()
        self._lifeline, our_end = os.pipe()
        for end in (self._lifeline, our_end):
            self._exits.callback(os.close, end)
        self._server: subprocess.Popen[bytes] | None = None
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
        """Of the processes that run."""
        processes = (self._server, self._window and self._window.process)
        return tuple(p.pid for p in processes if p is not None and p.poll() is None)

    def start(self, world: Path, *, seen: bool) -> None:
        """Run gzserver with ``world`` and the bridge.

        Unless it is ``seen`` by a gzclient of ours, ``~/physics/contacts`` stays empty:
        to publish it at each step, to nobody, takes a tenth of the time.
        """
        quiet = () if seen else ("--minimal_comms",)
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
        # Its own HOME is the person's: what they set up in the window stays.
        home = os.environ.get("HOME", str(self.folder))
        log = self.folder / "gzclient.log"
        self._window = ClientWindow(
            lambda: self._run(client, ["--verbose"], log, {"HOME": home}), log
        )

    def check(self) -> None:
        """Raise EngineUnavailableError if the server has ended."""
        if self._server is None or self._server.poll() is not None:
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
        try:
            if self._server is not None:
                self._server.wait(_GRACE)
        except subprocess.TimeoutExpired:
            pass
        error = EngineUnavailableError(exit_report(why, self._server, self._log))
        self.close()
        return error

    def close(self) -> None:
        """End both processes and remove the folder; closing twice is allowed."""
        if self._window is not None:
            self._window.close()
        if self._server is not None:
            self._server.kill()  # nothing of its outlives the folder
            self._server.wait()
        self._exits.close()

    def _run(
        self, program: Path, arguments: list[str], log: Path, extra: Mapping[str, str]
    ) -> subprocess.Popen[bytes]:
        preload = [str(self._libraries.leash), os.environ.get("LD_PRELOAD", "")]
        environment = {
            **os.environ,
            **self._installation.environment,
            "HOME": str(self.folder),
            "GAZEBO_MASTER_URI": self.master_uri,
            "GAZEBO_IP": "127.0.0.1",
            "IGN_IP": "127.0.0.1",
            "GAZEBO_MODEL_DATABASE_URI": "",  # or it waits for the network
            "TOOL0_LIFELINE": str(self._lifeline),
            "LD_PRELOAD": ":".join(filter(None, preload)),
            **extra,
        }
        with log.open("wb") as stream:
            return subprocess.Popen(
                [str(program), *arguments],
                env=environment,
                cwd=self.folder,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                pass_fds=[self._lifeline],
                start_new_session=True,  # a Ctrl-C is for us, who end it in order
            )


@contextlib.contextmanager
def _own_folder() -> Iterator[Path]:
    """Make a folder that is removed at the end, or by the next one if we are killed."""
    parent = Path(tempfile.gettempdir())
    for left in parent.glob(f"{_FOLDER}*/{_LOCK}"):
        # A running one is locked, and one that begins has no lock yet.
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
