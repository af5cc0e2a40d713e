"""A gzserver of our own, and its gzclient: started, watched, ended."""

from __future__ import annotations

import contextlib
import logging
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final, final

from tool0.engines.gazebo.installation import Installation
from tool0.engines.gazebo.plugin import BridgeLibraries
from tool0.errors import EngineUnavailableError
from tool0.user_data import locked

logger = logging.getLogger(__name__)

_LAST_LINES = 12
_GRACE = 0.2  # [s] for a server that hung up to end by itself
_FOLDER: Final = "tool0-gazebo-"
_LOCK: Final = "lock"
_NEW_LOCK: Final = "lock.new"
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
_CHATTER: Final = re.compile(
    r"$|Gazebo multi-robot simulator|Copyright|Released under|http://gazebosim"
    r"|\[Msg\]|\[\w+\] \[RenderEngine"  # which draws nothing without a display
    r"|Error:\s+Could not find the 'robot'"  # before it tries SDF
)
"""What every gzserver says, and what a reason is not among."""
_COMPLAINT: Final = re.compile(r"\[Err\]|Error|\[Wrn\] \[Server")


@final
class Server:
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
        self._heard = 0
        self._port = _free_port()
        self._lifeline, our_end = os.pipe()
        for end in (self._lifeline, our_end):
            self._exits.callback(os.close, end)
        self._server: subprocess.Popen[bytes] | None = None
        self._client: subprocess.Popen[bytes] | None = None

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
        processes = (self._server, self._client)
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
        self._client = self._run(client, ["--verbose"], log, {"HOME": home})
        watch = threading.Thread(
            target=_tell_of_crash,
            args=(self._client, log),
            name="gzclient",
            daemon=True,
        )
        watch.start()

    def check(self) -> None:
        """Raise EngineUnavailableError if the server has ended."""
        if self._server is None or self._server.poll() is not None:
            raise EngineUnavailableError(
                _obituary("gzserver did not start", self._server, self._log)
            )

    def complaints(self) -> list[str]:
        """Return the errors in what the server said since the last call."""
        said = _said(self._log)
        new, self._heard = said[self._heard :], len(said)
        return [line for line in new if _COMPLAINT.match(line)]

    def lost(self, why: str) -> EngineUnavailableError:
        """End what is left of the server, and return the error that says so."""
        try:
            if self._server is not None:
                self._server.wait(_GRACE)
        except subprocess.TimeoutExpired:
            pass
        error = EngineUnavailableError(_obituary(why, self._server, self._log))
        self.close()
        return error

    def close(self) -> None:
        """End both processes and remove the folder; closing twice is allowed."""
        for process in (self._client, self._server):
            if process is not None:
                if process.poll() is None:
                    process.kill()  # nothing of theirs outlives the folder
                process.wait()
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


def _tell_of_crash(client: subprocess.Popen[bytes], log: Path) -> None:
    """Wait for the window's end; a person may close it, and so may we."""
    if client.wait() not in (0, -signal.SIGKILL):
        logger.warning("%s", _obituary("Gazebo's window is gone", client, log))


def _obituary(why: str, process: subprocess.Popen[bytes] | None, log: Path) -> str:
    status = None if process is None else process.poll()
    if status is None:
        how = ""
    elif status < 0:
        how = f", killed by {signal.Signals(-status).name}"
    else:
        how = f", exit status {status}"
    words = "".join(f"\n  {line}" for line in _said(log)[-_LAST_LINES:])
    said = f"; its last words:{words}" if words else "; it said nothing"
    return f"{why}{how}{said}"


def _said(log: Path) -> list[str]:
    try:
        text = log.read_text(errors="replace")
    except OSError:
        return []
    lines = (line.rstrip() for line in _COLOUR.sub("", text).splitlines())
    return [line for line in lines if not _CHATTER.match(line)]


def require_window(installation: Installation) -> Path:
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


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
