"""The process of the ROS 2 node: it starts with a robot, and ends with it.

The node itself is the ROS package ``tool0_ros2`` in ``ros_packages``.
"""

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
from typing import TYPE_CHECKING, Final, final

from tool0.errors import RosUnavailableError
from tool0.installation.child_process import ChildProcess
from tool0.installation.ros2.installation import NODE_FOLDER, Ros2, find_ros2
from tool0.interfaces.ros2.options import Ros2Options

if TYPE_CHECKING:
    from tool0.api.robot import Robot

logger = logging.getLogger(__name__)

START_TIMEOUT: Final = 60.0
"""Longest wait for the node to be up [wall s]."""
FIRST_PAUSE: Final = 0.5
"""Before the node starts again after its death [wall s]; twice as long each time."""
LONGEST_PAUSE: Final = 30.0
"""[wall s]"""
_GRACE: Final = 3.0
"""For the node to end by itself [wall s]."""
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


@final
class Ros2Node(contextlib.AbstractContextManager["Ros2Node"]):
    """Presents one robot in ROS 2 as ros2_control does.  A context manager.

    The node runs in a process of its own, under the Python of a ROS 2.  It starts again
    when it dies.
    """

    def __init__(self, robot: Robot | str, options: Ros2Options | None = None) -> None:
        """Start the node; ``wait`` waits until it is up.

        Args:
            robot: A robot of this process or another one, which the caller closes
                after this; or the name of a bring-up, which may start later.
            options: The namespace, the domain and rates.

        Raises:
            RosUnavailableError: If there is no ROS 2.
        """
        self.options = options or Ros2Options()
        ros2 = find_ros2()
        if ros2 is None:
            raise RosUnavailableError(
                "there is no ROS 2 on this machine: source one, or run "
                "`tool0 ros2 install`"
            )
        self.ros2 = ros2
        with contextlib.ExitStack() as stack:
            name = robot if isinstance(robot, str) else _served(robot, stack)
            self._command, self._environment = _program(ros2, name, self.options)
            self._lines: deque[str] = deque(maxlen=_LAST_LINES)
            self._is_closing = threading.Event()
            self._changed = threading.Condition()
            self._node: str | None = None
            self._failure: str | None = None
            self._child: ChildProcess | None = None
            self._thread = threading.Thread(
                target=self._supervise, name="tool0 ros2", daemon=True
            )
            self._thread.start()
            self._stack = stack.pop_all()

    @property
    def domain(self) -> int:
        """The ROS_DOMAIN_ID that it is in."""
        return int(self._environment.get("ROS_DOMAIN_ID") or 0)

    def wait(self, timeout: float = START_TIMEOUT) -> str:
        """Wait until the node is up, and return its full name.

        Raises:
            RosUnavailableError: If it could not start, or not within ``timeout``
                [wall s].
        """
        with self._changed:
            self._changed.wait_for(lambda: self._node or self._failure, timeout)
            if self._node is not None:
                return self._node
            why = self._failure or f"it is not up after {timeout:g} s"
        raise RosUnavailableError(f"the ROS 2 node did not start: {why}")

    @property
    def pid(self) -> int | None:
        """The process id of the node; None while it does not run."""
        child = self._child
        return None if child is None else child.pid

    def close(self) -> None:
        """End the node; closing twice is allowed."""
        self._is_closing.set()
        child = self._child
        if child is not None:
            child.close()
        self._thread.join()
        self._stack.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    # ---- in its thread --------------------------------------------------------------

    def _supervise(self) -> None:
        """Run the node, again and again, until this is closed."""
        pause = FIRST_PAUSE
        while not self._is_closing.is_set():
            start = time.monotonic()
            status = self._run()
            if self._is_closing.is_set():
                return
            last = "\n".join(f"  {line}" for line in self._lines)
            if self._node is None:
                with self._changed:
                    self._failure = f"it ended with status {status}.\n{last}"
                    self._changed.notify_all()
                return
            if time.monotonic() - start > LONGEST_PAUSE:
                pause = FIRST_PAUSE
            logger.warning(
                "the ROS 2 node ended with status %s; it starts again in %g s%s",
                status,
                pause,
                f".  Its last output:\n{last}" if last else "",
            )
            self._is_closing.wait(pause)
            pause = min(2.0 * pause, LONGEST_PAUSE)

    def _run(self) -> int:
        """Run the node to its end; return its exit status."""
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
                for line in output:
                    self._take(line.rstrip("\n"))
                status = child.wait()
        self._child = None
        return status

    def _take(self, line: str) -> None:
        """Take a line of the node's output: a report, or of its log."""
        if line.startswith("{"):
            with contextlib.suppress(ValueError):
                report = json.loads(line)
                if report.get("ready"):
                    with self._changed:
                        self._node = report["node"]
                        self._changed.notify_all()
                    return
        if not line.strip() or self._is_closing.is_set():
            return
        found = _LINE.match(line)
        if found is None:
            self._lines.append(line)
            logger.warning("ROS 2 node: %s", line)
        else:
            level, text = found.groups()
            logger.log(_LEVELS[level], "ROS 2 %s", text)


def _program(
    ros2: Ros2, name: str, options: Ros2Options
) -> tuple[list[str], dict[str, str]]:
    """Return the command of the node, and its variables."""
    environment = dict(ros2.environment)
    paths = [str(NODE_FOLDER), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
    environment["PYTHONUNBUFFERED"] = "1"
    if options.domain is not None:
        environment["ROS_DOMAIN_ID"] = str(options.domain)
    command = [
        *(str(ros2.python), "-m", NODE_FOLDER.name),
        *("--name", name, "--ns", options.ns, "--wait"),
        *("--tf-rate", repr(options.tf_rate)),
        *("--camera-rate", repr(options.camera_rate)),
    ]
    return command, environment


def _served(robot: Robot, stack: contextlib.ExitStack) -> str:
    """Return the name at which a robot is served, and serve it if it is ours."""
    from tool0.api.connect import SocketChannel

    if isinstance(robot.channel, SocketChannel):
        return robot.channel.name
    from tool0.api.address import Claim
    from tool0.interfaces.server.backend import SimulationBackend
    from tool0.interfaces.server.server import Server, UnixSocketService

    claim = Claim(f"ros2-{os.getpid()}-{next(_numbers)}")
    stack.callback(claim.close)
    service = UnixSocketService(claim)
    stack.enter_context(
        Server(SimulationBackend(robot.simulation), [service], claim.name)
    )
    return claim.name
