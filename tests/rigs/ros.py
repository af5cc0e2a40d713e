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
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

from waits import LONGEST, until

from tool0.installation.child_process import ChildProcess

TIMEOUT = LONGEST
_CALLER = "/test"
_GRACE = 5.0
"""For programs of ROS to end by themselves [wall s]."""
_LAST_LINES = 60
"""Of a program's output, in the report of a failed test."""
_UNSET = ("ROS_HOSTNAME", "ROS_NAMESPACE", "ROS_OS_OVERRIDE", "ROSCONSOLE_CONFIG_FILE")


class Ros:
    """A roscore on a port of its own, on 127.0.0.1 only."""

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
        """End the roscore; programs started under it continue."""
        if self._core is not None:
            self._core.close()
            self._core = None

    @property
    def is_up(self) -> bool:
        try:
            return bool(self.call_master("getPid"))
        except OSError:
            return False

    def call_master(self, method: str, *arguments: object) -> Any:
        """Return the master's response, None if it refuses."""
        with ServerProxy(self.uri) as proxy:
            code, _, value = getattr(proxy, method)(_CALLER, *arguments)
        return value if code == 1 else None

    def address_of(self, node: str) -> str | None:
        found: str | None = self.call_master("lookupNode", node)
        return found

    def parameter(self, name: str) -> Any:
        """Return its value, None if it is not set."""
        return self.call_master("getParam", name)

    def services(self) -> set[str]:
        return {name for name, _ in self.call_master("getSystemState")[2]}

    def publishers(self) -> dict[str, list[str]]:
        """Return topic → nodes that publish it."""
        return dict(self.call_master("getSystemState")[0])

    def wait_for_service(self, name: str) -> None:
        until(lambda: name in self.services(), f"service {name}")

    # --- programs under it ---

    @property
    def tools(self) -> Mapping[str, str]:
        """The environment of a terminal after ``eval "$(tool0 ros1 env)"``."""
        if self._tools is None:
            answer = subprocess.run(
                [
                    *("bash", "-c", 'eval "$("$0" -m tool0 ros1 env)" && env -0'),
                    sys.executable,
                ],
                env=dict(self.environment),
                capture_output=True,
                text=True,
                timeout=TIMEOUT,
                check=False,
            )
            assert answer.returncode == 0, answer.stderr
            pairs = (row.partition("=") for row in answer.stdout.split("\0") if row)
            self._tools = {name: value for name, _, value in pairs}
        return self._tools

    def run(self, *command: str, timeout: float = TIMEOUT) -> str:
        """Run a program to its end and return its output; it has to succeed."""
        answer = self.outcome(*command, timeout=timeout)
        assert answer.returncode == 0, (command, answer.stdout, answer.stderr)
        return answer.stdout

    def outcome(
        self, *command: str, timeout: float = TIMEOUT
    ) -> subprocess.CompletedProcess[str]:
        """Run a program to its end, or to Ctrl-C after ``timeout`` [wall s]."""
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
                out, error = process.communicate(timeout=timeout)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
                try:
                    out, error = process.communicate(timeout=TIMEOUT)
                finally:
                    process.kill()
        return subprocess.CompletedProcess(command, process.returncode, out, error)

    def wait_for_rate(self, topic: str, rate: float, window: int = 250) -> None:
        """Wait until ``rostopic hz`` measures ``rate`` [Hz] over ``window`` messages.

        An arrival that is a tick late or early makes 0.5 Hz of 250 messages; a busy
        machine is late for longer now and then.
        """
        with subprocess.Popen(
            ["rostopic", "hz", topic, "-w", str(window)],
            env={**self.tools, "PYTHONUNBUFFERED": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        ) as process:
            assert process.stdout is not None
            printed: list[str] = []
            try:
                for line in process.stdout:
                    printed.append(line)
                    if not line.rstrip().endswith(f"window: {window}"):
                        continue
                    measured = float(printed[-2].removeprefix("average rate: "))
                    if abs(measured - rate) < 1.0:
                        return
            finally:
                process.kill()
        raise AssertionError("".join(printed))

    def python(self, program: str, *arguments: str, timeout: float = TIMEOUT) -> str:
        """Run a script of rospy in the system's Python."""
        return self.run(system_python(), "-c", program, *arguments, timeout=timeout)

    def spawn(self, *command: str, **variables: str) -> ChildProcess:
        """Start a program that ends with the roscore at the latest.

        ``variables`` are set in its environment.
        """
        environment = {**self.tools, **variables}
        child = ChildProcess(command, environment=environment, grace=_GRACE)
        self._started.append(child)
        return child

    def bring_up(self, *options: str, wait: bool = True) -> Bringup:
        """Run ``tool0 bringup --ros1 --headless``, and wait until it is up."""
        bringup = Bringup(self.environment, "--ros1", *options)
        self._started.append(bringup)
        if wait:
            bringup.wait()
        return bringup

    def outputs(self) -> dict[str, str]:
        """Return the last lines of every program under it, by name."""
        names = {} if self._core is None else {"roscore": self._core.last_output()}
        for number, one in enumerate(self._started, start=1):
            if isinstance(one, Bringup) and not one.is_closed:
                names |= {
                    f"{number}: {name}": text for name, text in one.outputs().items()
                }
        return names

    def __enter__(self) -> Ros:
        return self.start()

    def __exit__(self, *_: object) -> None:
        for one in reversed(self._started):
            one.close()
        self.stop()
        self._folder.cleanup()


class Bringup:
    """``tool0 bringup --headless`` in a process of its own."""

    def __init__(self, environment: Mapping[str, str], *options: str) -> None:
        self._sockets = tempfile.TemporaryDirectory(prefix="tool0-")
        self._began = time.monotonic()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tool0", "bringup", "--headless", *options],
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
        """Its output, up to the line that was waited for."""
        self._printed: list[str] = []
        """All of its output, with the time of each line [wall s from its start]."""
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

    @property
    def runtime_folder(self) -> str:
        """The ``XDG_RUNTIME_DIR`` in which its socket is."""
        return self._sockets.name

    def wait_for(self, words: str, timeout: float = TIMEOUT) -> str:
        """Return the first new line that contains ``words``."""
        deadline = time.monotonic() + timeout
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
        """End it by a signal; return its exit status."""
        self.process.send_signal(number)
        return self.wait_for_end()

    def wait_for_end(self) -> int:
        status = self.process.wait(TIMEOUT)
        self._reader.join(TIMEOUT)
        while not self._arrived.empty():
            self.lines.append(self._arrived.get() or "")
        return status

    @property
    def text(self) -> str:
        return "\n".join(self.lines)

    @property
    def is_closed(self) -> bool:
        return self.process.stdout is None or self.process.stdout.closed

    def outputs(self) -> dict[str, str]:
        """Return the last lines of it and of its Gazebo, by name."""
        texts = {"bring-up": self._printed}
        for log in Path(self._sockets.name).glob("*/*.log"):
            texts[log.name] = log.read_text(errors="replace").splitlines()
        return {name: "\n".join(rows[-_LAST_LINES:]) for name, rows in texts.items()}

    def close(self) -> None:
        """End it, by SIGKILL if need be; closing twice is allowed."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(TIMEOUT)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._reader.join(TIMEOUT)
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
