"""A real ROS 1 for tests: a roscore of their own, its tools, and bring-ups under it."""

from __future__ import annotations

import os
import queue
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any
from xmlrpc.client import ServerProxy

from tool0.installation.child_process import ChildProcess

PATIENCE = 60.0
"""For what takes a moment on a busy machine [wall s]."""
_GLANCE = 0.02
"""Between two looks at what announces nothing [wall s]."""
_CALLER = "/test"
_GRACE = 5.0
"""That programs of ROS have to end by themselves [wall s]."""
_LAST_LINES = 60
"""Of what a program printed, for who reads that a test failed."""
_UNSET = ("ROS_HOSTNAME", "ROS_NAMESPACE", "ROS_OS_OVERRIDE", "ROSCONSOLE_CONFIG_FILE")


def until(is_so: Callable[[], Any], what: str, patience: float = PATIENCE) -> Any:
    """Return the first true answer of ``is_so``; fail if there is none in time."""
    deadline = time.monotonic() + patience
    while not (answer := is_so()):
        assert time.monotonic() < deadline, f"{what}: not within {patience:g} s"
        time.sleep(_GLANCE)
    return answer


class Ros:
    """A roscore on a port of its own, reached from this machine alone."""

    def __init__(self, port: int | None = None) -> None:
        self.port = port or free_port()
        self.uri = f"http://127.0.0.1:{self.port}"
        self._folder = tempfile.TemporaryDirectory(prefix="ros-")
        own = {
            "ROS_MASTER_URI": self.uri,
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": self._folder.name,
            "ROS_LOG_DIR": str(Path(self._folder.name, "log")),
            "PYTHONUNBUFFERED": "1",
        }
        inherited = {k: v for k, v in os.environ.items() if k not in _UNSET}
        self.environment: Mapping[str, str] = {**inherited, **own}
        self._core: ChildProcess | None = None
        self._tools: Mapping[str, str] | None = None
        self._started: list[ChildProcess | Bringup] = []

    # --- the master ---

    def start(self) -> Ros:
        """Start the roscore and wait for it."""
        command = [shutil.which("roscore") or "roscore", "-p", str(self.port)]
        self._core = core = ChildProcess(
            command, environment=self.environment, grace=_GRACE
        )

        def is_up() -> bool:
            assert core.exit_status is None, core.last_output()
            return self.is_up and self.address_of("/rosout") is not None

        until(is_up, f"roscore at {self.uri}")
        return self

    def stop(self) -> None:
        """End the roscore; what was started under it goes on."""
        if self._core is not None:
            self._core.close()
            self._core = None

    @property
    def is_up(self) -> bool:
        try:
            return bool(self.ask("getPid"))
        except OSError:
            return False

    def ask(self, method: str, *arguments: object) -> Any:
        """Return what the master answers, None if it says no."""
        with ServerProxy(self.uri) as proxy:
            code, _, value = getattr(proxy, method)(_CALLER, *arguments)
        return value if code == 1 else None

    def address_of(self, node: str) -> str | None:
        found: str | None = self.ask("lookupNode", node)
        return found

    def parameter(self, name: str) -> Any:
        """Return its value, None if it is not set."""
        return self.ask("getParam", name)

    def services(self) -> set[str]:
        return {name for name, _ in self.ask("getSystemState")[2]}

    def publishers(self) -> dict[str, list[str]]:
        """Return topic → nodes that publish it."""
        return dict(self.ask("getSystemState")[0])

    def wait_for_parameter(self, name: str) -> Any:
        return until(lambda: self.parameter(name), f"parameter {name}")

    def wait_for_service(self, name: str) -> None:
        until(lambda: name in self.services(), f"service {name}")

    def wait_for_publisher(self, topic: str) -> None:
        until(lambda: self.publishers().get(topic), f"publisher of {topic}")

    # --- programs under it ---

    @property
    def tools(self) -> Mapping[str, str]:
        """What a terminal has after ``eval "$(tool0 ros1 env)"``."""
        if self._tools is None:
            answer = subprocess.run(
                [
                    *("bash", "-c", 'eval "$("$0" -m tool0 ros1 env)" && env -0'),
                    sys.executable,
                ],
                env=dict(self.environment),
                capture_output=True,
                text=True,
                timeout=PATIENCE,
                check=False,
            )
            assert answer.returncode == 0, answer.stderr
            pairs = (row.partition("=") for row in answer.stdout.split("\0") if row)
            self._tools = {name: value for name, _, value in pairs}
        return self._tools

    def run(self, *command: str, patience: float = PATIENCE) -> str:
        """Run one of ROS's programs to its end; return what it prints."""
        answer = self.outcome(*command, patience=patience)
        assert answer.returncode == 0, (command, answer.stdout, answer.stderr)
        return answer.stdout

    def outcome(
        self, *command: str, patience: float = PATIENCE
    ) -> subprocess.CompletedProcess[str]:
        """Run it to its end, or to Ctrl-C after ``patience`` [wall s]."""
        with subprocess.Popen(
            command,
            env=dict(self.tools),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        ) as process:
            try:
                out, error = process.communicate(timeout=patience)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
                try:
                    out, error = process.communicate(timeout=PATIENCE)
                finally:
                    process.kill()
        return subprocess.CompletedProcess(command, process.returncode, out, error)

    def python(self, program: str, *arguments: str, patience: float = PATIENCE) -> str:
        """Run a program of rospy in the system's Python, as a person's script is."""
        return self.run(system_python(), "-c", program, *arguments, patience=patience)

    def spawn(self, *command: str) -> ChildProcess:
        """Start a program that ends with the roscore at the latest."""
        child = ChildProcess(command, environment=self.tools, grace=_GRACE)
        self._started.append(child)
        return child

    def bring_up(self, *options: str, wait: bool = True) -> Bringup:
        """Run ``tool0 bringup --ros1 --headless``, and wait until it is up."""
        bringup = Bringup(self.environment, *options)
        self._started.append(bringup)
        if wait:
            bringup.wait()
        return bringup

    def said(self) -> dict[str, str]:
        """Return what those printed that run under it: name → the last lines."""
        names = {} if self._core is None else {"roscore": self._core.last_output()}
        for number, one in enumerate(self._started, start=1):
            if isinstance(one, Bringup) and not one.is_closed:
                names |= {
                    f"{number}: {name}": text for name, text in one.said().items()
                }
        return names

    def __enter__(self) -> Ros:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for one in reversed(self._started):
            one.close()
        self.stop()
        self._folder.cleanup()


class Bringup:
    """``tool0 bringup --ros1`` in a process of its own."""

    def __init__(self, environment: Mapping[str, str], *options: str) -> None:
        self._sockets = tempfile.TemporaryDirectory(prefix="tool0-")
        self._began = time.monotonic()
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-m", "tool0", "bringup", "--ros1", "--headless"),
                *options,
            ],
            env={
                **environment,
                "XDG_RUNTIME_DIR": self._sockets.name,
                "TMPDIR": self._sockets.name,  # with its gzserver's log
            },
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self.lines: list[str] = []
        """What it printed, up to what was waited for."""
        self._printed: list[str] = []
        """All of it, with the time of each line [wall s from its start]."""
        self._arrived: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._printed.append(
                f"{time.monotonic() - self._began:7.2f} {line.rstrip()}"
            )
            self._arrived.put(line.rstrip())
        self._arrived.put(None)

    def wait_for(self, words: str, patience: float = PATIENCE) -> str:
        """Return the first new line that holds ``words``."""
        deadline = time.monotonic() + patience
        while True:
            try:
                line = self._arrived.get(timeout=max(deadline - time.monotonic(), 0.0))
            except queue.Empty:
                line = None
            assert line is not None, f"no line with '{words}' in:\n{self.text}"
            self.lines.append(line)
            if words in line:
                return line

    def wait(self) -> None:
        """Wait until it is up, ROS included."""
        self.wait_for("Ctrl-C")

    def end(self, number: signal.Signals = signal.SIGINT) -> int:
        """Let it end, as by Ctrl-C; return its exit status."""
        self.process.send_signal(number)
        return self.wait_for_end()

    def wait_for_end(self) -> int:
        status = self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)
        while not self._arrived.empty():
            self.lines.append(self._arrived.get() or "")
        return status

    @property
    def text(self) -> str:
        return "\n".join(self.lines)

    @property
    def is_closed(self) -> bool:
        return self.process.stdout is None or self.process.stdout.closed

    def said(self) -> dict[str, str]:
        """Return what it and its Gazebo printed: name → the last lines."""
        texts = {"bring-up": self._printed}
        for log in Path(self._sockets.name).glob("*/*.log"):
            texts[log.name] = log.read_text(errors="replace").splitlines()
        return {name: "\n".join(rows[-_LAST_LINES:]) for name, rows in texts.items()}

    def close(self) -> None:
        """End it however it is; closing twice is allowed."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._reader.join(PATIENCE)
        if self.process.stdout is not None:
            self.process.stdout.close()
        self._sockets.cleanup()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def system_python() -> str:
    """Return the Python of ROS's own tools."""
    roscore = Path(shutil.which("roscore") or "")
    first = roscore.read_text(encoding="utf-8").splitlines()[0].removeprefix("#!")
    words = first.split()
    return shutil.which(words[-1]) or words[-1]
