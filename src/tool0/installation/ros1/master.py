"""Finds or starts the ROS master, and registers again when the master is restarted."""

from __future__ import annotations

import contextlib
import logging
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from typing import Any, final
from urllib.parse import urlsplit
from xmlrpc.client import Error, ServerProxy, Transport

from tool0.errors import RosUnavailableError
from tool0.installation.child_process import ChildProcess
from tool0.installation.ros1.library import is_local

logger = logging.getLogger(__name__)

ROSCORE_TIMEOUT = 20.0
"""Longest time until our roscore answers [s].  A roscore usually answers after 2 s."""
UNREGISTER_TIMEOUT = 5.0
"""Time limit for removing our node from the master [wall s].  Removing the node takes
dozens of calls, and each call is slow on a busy machine."""
_QUIET = 0.05
"""Time for which the node must remain unregistered before its removal is complete [wall
s]."""
_SUBSCRIBED_BY_ROSPY = "/rosout_disable_topics_generation"
"""Parameter to which rospy subscribes permanently when it logs its first warning."""
_POLL_PERIOD = 0.01
"""Interval between two calls when the master is polled [wall s]."""
CALL_TIMEOUT = 3.0
"""Time limit of a call to the master [s]."""
ROSCORE_GRACE = 5.0
"""Time limit for our roscore to end when it is stopped [s]."""


@final
class _TimeLimitedTransport(Transport):
    def make_connection(self, host: Any) -> HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = CALL_TIMEOUT
        return connection


@final
class Master:
    """Calls the master under the name of our node.  Any thread may use an instance."""

    def __init__(self, node: str) -> None:
        import rosgraph

        self._node = node
        try:
            self.uri = str(rosgraph.get_master_uri())
        except ValueError as error:
            raise RosUnavailableError(f"ROS_MASTER_URI: {error}") from None

    # The result may have any type that XML-RPC supports.
    def call(self, method: str, *arguments: object) -> Any:
        """Call a method of the master, and return the value in the master's answer.

        Raises:
            RosUnavailableError: If there is no answer, or if the master refuses the
                call.
        """
        code, message, value = self._call(self.uri, method, *arguments)
        if code != 1:
            raise RosUnavailableError(f"the ROS master refuses {method}: {message}")
        return value

    def _call(self, uri: str, method: str, *arguments: object) -> tuple[int, str, Any]:
        try:
            with ServerProxy(uri, transport=_TimeLimitedTransport()) as proxy:
                code, message, value = getattr(proxy, method)(self._node, *arguments)
        except (Error, OSError, ValueError, TypeError) as error:
            raise RosUnavailableError(
                f"no ROS master answers at {uri} ({error}); start roscore, "
                "or add --roscore"
            ) from None
        return code, message, value

    @property
    def is_up(self) -> bool:
        """Whether the master answers."""
        try:
            self.call("getPid")
        except RosUnavailableError:
            return False
        return True

    def uri_of(self, node: str) -> str | None:
        """Return a node's address, or None if the node is not running."""
        try:
            uri = str(self.call("lookupNode", node))
            code, _, _ = self._call(uri, "getPid")
        except RosUnavailableError:
            # the node is unknown, or it was killed without being unregistered
            return None
        return uri if code == 1 else None

    def publishers_of(self, topic: str) -> tuple[str, ...]:
        """Return the nodes that publish ``topic``, including dead nodes."""
        publishers, _, _ = self.call("getSystemState")
        return next((tuple(nodes) for name, nodes in publishers if name == topic), ())

    def unregister_all(self, uri: str) -> None:
        """Remove all registrations of our node at the address ``uri``.

        The removal is repeated until the node remains unregistered for some time,
        because a registration that a rospy thread has started may still reach the
        master.
        """
        end = time.monotonic() + UNREGISTER_TIMEOUT
        self._unregister_once(uri)
        unknown_since = time.monotonic()
        while (now := time.monotonic()) < end and now - unknown_since < _QUIET:
            if self._knows(self._node):
                self._unregister_once(uri)
                unknown_since = time.monotonic()
            else:
                time.sleep(_POLL_PERIOD)

    def _knows(self, node: str) -> bool:
        """Return whether a node is registered.  A dead node may be registered."""
        try:
            self.call("lookupNode", node)
        except RosUnavailableError:
            return False
        return True

    def _unregister_once(self, uri: str) -> None:
        publishers, subscribers, services = self.call("getSystemState")
        for topic, nodes in publishers:
            if self._node in nodes:
                self.call("unregisterPublisher", topic, uri)
        for topic, nodes in subscribers:
            if self._node in nodes:
                self.call("unregisterSubscriber", topic, uri)
        for service, nodes in services:
            if self._node in nodes:
                # the node has been unregistered in the meantime
                with contextlib.suppress(RosUnavailableError):
                    address = self.call("lookupService", service)
                    self.call("unregisterService", service, address)
        self.call("unsubscribeParam", uri, _SUBSCRIBED_BY_ROSPY)


@contextmanager
def running_master(master: Master, *, start: bool) -> Iterator[None]:
    """Provide a running master or our own roscore within the context.

    Raises:
        RosUnavailableError: If no master answers, and none can be started or starting
            one is not allowed.
    """
    if master.is_up:
        yield
        return
    if not start:
        raise RosUnavailableError(
            f"no ROS master answers at {master.uri}; start roscore, or add --roscore"
        )
    with _roscore(master) as roscore:
        end = time.monotonic() + ROSCORE_TIMEOUT
        while not master.is_up:
            if roscore.exit_status is not None:
                how = f"ended with status {roscore.exit_status}"
            elif time.monotonic() > end:
                how = f"does not answer at {master.uri} within {ROSCORE_TIMEOUT:g} s"
            else:
                time.sleep(0.05)
                continue
            raise RosUnavailableError(f"roscore {how}:\n{roscore.last_output()}")
        yield


def _roscore(master: Master) -> ChildProcess:
    program = shutil.which("roscore")
    if program is None:
        raise RosUnavailableError(
            "there is no roscore on the PATH; `tool0 ros1 install` installs one"
        )
    if not is_local(master.uri):
        raise RosUnavailableError(
            f"ROS_MASTER_URI is {master.uri}, on another machine: start roscore there"
        )
    port = urlsplit(master.uri).port or 11311
    return ChildProcess([program, "-p", str(port)], grace=ROSCORE_GRACE)


@final
class MasterWatch:
    """Registers our node again if the master was unavailable or lost our node."""

    def __init__(
        self, master: Master, node: str, uri: str, register: Callable[[], None]
    ) -> None:
        """Store ``register``, which is called when our registration is missing.

        The registration is missing if a master runs but does not have our node at
        ``uri``.
        """
        self._master = master
        self._node = node
        self._uri = uri
        self._register = register
        self._is_gone = False

    def check(self) -> None:
        """Check once.  Call this method about once a second, from a single thread."""
        if not self._master.is_up:
            if not self._is_gone:
                logger.warning(
                    "the ROS master at %s is gone; connections remain, and "
                    "tool0 registers again when it is back",
                    self._master.uri,
                )
            self._is_gone = True
            return
        if self._is_gone or not self._is_known():
            self._register()
            logger.warning("registered again with the ROS master")
        self._is_gone = False

    def _is_known(self) -> bool:
        try:
            return bool(self._master.call("lookupNode", self._node) == self._uri)
        except RosUnavailableError:
            return False
