"""A real ROS 2 for tests: a domain of their own, its programs, and bring-ups in it."""

from __future__ import annotations

import os
import random
import signal
import socket
import subprocess
from collections.abc import Iterator, Mapping

from promised import require_ros2
from ros import TIMEOUT, Bringup
from ros2_client import Client

from tool0.installation.child_process import ChildProcess

_DOMAINS = range(30, 102)
"""Those whose ports no system gives to programs that ask for any, less the first."""
_GRACE = 5.0
"""For programs of ROS to end by themselves [wall s]."""
_SOURCED = ("AMENT_PREFIX_PATH", "ROS_DISTRO")
"""What `tool0 ros2 env` sets to select tool0's own ROS 2."""
_UNSET = ("ROS_LOCALHOST_ONLY", "ROS_NAMESPACE", "ROS_STATIC_PEERS")


class Domain:
    """A ROS 2 domain, on this machine only, with nobody else in it."""

    def __init__(self) -> None:
        self.ros2 = ros2 = require_ros2()
        self._claim, self.id = _free_domain()
        own = {"ROS_DOMAIN_ID": str(self.id)}
        own |= (
            {"ROS_LOCALHOST_ONLY": "1"}
            if ros2.distro == "humble"
            else {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        )
        self.variables: Mapping[str, str] = {
            **own,
            # A test's data folder is without the person's own installation.
            **{name: ros2.environment[name] for name in _SOURCED if ros2.kind == "own"},
        }
        """What a terminal has in this domain."""
        inherited = {k: v for k, v in os.environ.items() if k not in _UNSET}
        inherited["PYTHONUNBUFFERED"] = "1"
        self.environment: Mapping[str, str] = {**inherited, **self.variables}
        """Of bring-ups in it."""
        self.ros_environment: Mapping[str, str] = {**ros2.environment, **own}
        """Of programs of ROS 2."""
        self._started: list[Client | Bringup | ChildProcess] = []

    def client(self) -> Client:
        """Start a client."""
        client = Client(self.ros2.python, self.ros_environment)
        self._started.append(client)
        return client

    def bring_up(self, *options: str, wait: bool = True) -> Bringup:
        """Run ``tool0 bringup --ros2 --headless``, and wait until it is up."""
        bringup = Bringup(self.environment, "--ros2", *options)
        self._started.append(bringup)
        if wait:
            bringup.wait()
        return bringup

    @property
    def bringups(self) -> list[Bringup]:
        """All that were started here."""
        return [one for one in self._started if isinstance(one, Bringup)]

    def spawn(self, *arguments: str) -> ChildProcess:
        """Start ROS 2's Python; it ends with the domain at the latest."""
        child = ChildProcess(
            [str(self.ros2.python), *arguments],
            environment=self.ros_environment,
            grace=_GRACE,
        )
        self._started.append(child)
        return child

    def run(self, *arguments: str, timeout: float = TIMEOUT) -> str:
        """Run ROS 2's Python to its end and return its output; it has to succeed."""
        answer = subprocess.run(
            [str(self.ros2.python), *arguments],
            env=dict(self.ros_environment),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        assert answer.returncode == 0, (arguments, answer.stdout, answer.stderr)
        return answer.stdout

    def outputs(self) -> dict[str, str]:
        """Return the last lines of every program in it, by name."""
        return {
            f"domain {self.id}, {number}: {name}": text
            for number, one in enumerate(self._started, start=1)
            if not isinstance(one, ChildProcess) and not one.is_closed
            for name, text in one.outputs().items()
        }

    def close(self) -> None:
        for one in reversed(self._started):
            one.close()
        self._claim.close()

    def __enter__(self) -> Domain:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _free_domain() -> tuple[socket.socket, int]:
    """Return a domain that nobody is in, with a socket that keeps it for us.

    DDS listens on UDP ports that the domain's number tells; the TCP port of the same
    number is ours, so that no other test takes the domain.
    """
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        port = 7400 + 250 * domain
        claim = socket.socket()
        try:
            claim.bind(("127.0.0.1", port))
            for first in _ports_of_first_participants(port):
                with socket.socket(type=socket.SOCK_DGRAM) as probe:
                    probe.bind(("", first))
        except OSError:
            claim.close()
        else:
            return claim, domain
    raise AssertionError("all domains are in use")


def _ports_of_first_participants(port: int) -> Iterator[int]:
    return (port + 10 + 2 * participant for participant in range(4))


def interrupt(child: ChildProcess) -> None:
    """Send Ctrl-C to a program."""
    os.kill(child.pid, signal.SIGINT)
