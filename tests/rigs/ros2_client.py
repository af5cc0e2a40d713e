"""The tests' end of `tests/ros2/client`: goals, topics, services, in real rclpy."""

from __future__ import annotations

import contextlib
import json
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ros import TIMEOUT
from waits import until

SCRIPT = Path(__file__).parent.parent / "ros2" / "client" / "rclpy_client.py"
_LAST_LINES = 40
"""Of a client's errors, in the report of a failed test."""
Message = Any
"""A message of ROS with its fields as attributes; times are numbers [s]."""


class ClientError(AssertionError):
    """The client could not do what it was told."""


class Client:
    """A process with a node of rclpy."""

    def __init__(self, python: Path, environment: Mapping[str, str]) -> None:
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115  (closed below)
        self.process = subprocess.Popen(
            [str(python), str(SCRIPT)],
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            start_new_session=True,
        )
        self._is_up = False

    def request(self, operation: str, **arguments: object) -> Any:
        """Execute an operation of the client and return its value."""
        assert self.process.stdin is not None
        if not self._is_up:
            self._read()
            self._is_up = True
        self.process.stdin.write(json.dumps([operation, arguments]) + "\n")
        self.process.stdin.flush()
        reply = self._read()
        if "error" in reply:
            raise ClientError(f"{operation} {arguments}: {reply['error']}"[:2000])
        return reply["value"]

    def _read(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, self.outputs()
        reply: dict[str, Any] = json.loads(line)
        return reply

    def messages(self, operation: str, **arguments: object) -> Any:
        """Return the value, with its objects as messages."""
        return as_message(self.request(operation, **arguments))

    # --- actions ---

    def send(self, action: str, kind: str, goal: Mapping[str, object]) -> Goal:
        """Send a goal and wait for the response."""
        reply = self.request(
            "send_goal", action=action, kind=kind, goal=goal, timeout=TIMEOUT
        )
        return Goal(self, reply["goal"], is_accepted=reply["accepted"])

    # --- topics ---

    @contextlib.contextmanager
    def listening(
        self,
        topic: str,
        kind: str,
        *,
        latched: bool = False,
        reliable: bool = True,
        wait: bool = True,
    ) -> Iterator[Topic]:
        """Subscribe; enter at the first message, or at once without ``wait``."""
        number = self.request(
            "subscribe", topic=topic, kind=kind, latched=latched, reliable=reliable
        )
        subscription = Topic(self, topic, number)
        try:
            if wait:
                subscription.wait_for()
            yield subscription
        finally:
            self.request("unsubscribe", subscription=number)

    def publish(
        self,
        topic: str,
        kind: str,
        message: Mapping[str, object],
        latched: bool = False,
    ) -> None:
        """Publish a message as soon as somebody subscribes."""
        self.request(
            "publish", topic=topic, kind=kind, message=message, latched=latched
        )

    # --- services and parameters ---

    def call(self, service: str, kind: str, /, **request: object) -> Message:
        """Return the response of a service."""
        return self.messages(
            "call", service=service, kind=kind, request=request, timeout=TIMEOUT
        )

    def parameters(self, node: str, *names: str) -> list[Any]:
        """Return values of a node's parameters; None for one that is not set."""
        response = self.call(
            f"{node}/get_parameters", "rcl_interfaces/srv/GetParameters", names=names
        )
        return [_from_value(value) for value in response.values]

    def set_parameters(self, node: str, **values: object) -> list[Message]:
        """Set them, one after the other; return whether, and if not why."""
        return self.set_named(node, values)

    def set_named(self, node: str, values: Mapping[str, object]) -> list[Message]:
        """Set parameters whose names have dots."""
        response = self.call(
            f"{node}/set_parameters",
            "rcl_interfaces/srv/SetParameters",
            parameters=[
                {"name": name, "value": _to_value(value)}
                for name, value in values.items()
            ],
        )
        results: list[Message] = response.results
        return results

    # --- the graph ---

    def nodes(self) -> list[str]:
        """Return the full names of all nodes."""
        found: list[str] = self.request("nodes")
        return found

    def topics(self) -> dict[str, list[str]]:
        """Return topic → types."""
        found: dict[str, list[str]] = self.request("topics")
        return found

    def services(self) -> dict[str, list[str]]:
        """Return service → types."""
        found: dict[str, list[str]] = self.request("services")
        return found

    def publishers(self, topic: str) -> list[Message]:
        """Return the node, type, and quality of service of each publisher."""
        found: list[Message] = self.messages("publishers", topic=topic)
        return found

    # --- its end ---

    @property
    def is_closed(self) -> bool:
        return self._errors.closed

    def outputs(self) -> dict[str, str]:
        """Return the last lines of its log."""
        self._errors.seek(0)
        return {"client": "".join(self._errors.readlines()[-_LAST_LINES:])}

    def close(self) -> None:
        """End it; closing twice is allowed."""
        if self.is_closed:
            return
        for stream in (self.process.stdin, self.process.stdout):
            if stream is not None:
                stream.close()
        try:
            self.process.wait(10.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._errors.close()


class Goal:
    """A goal that an action server has answered."""

    def __init__(self, client: Client, number: int, *, is_accepted: bool) -> None:
        self._client, self._number = client, number
        self.is_accepted = is_accepted

    @property
    def has_ended(self) -> bool:
        return bool(self._client.request("has_ended", goal=self._number))

    def outcome(self, timeout: float = TIMEOUT) -> tuple[str, Message]:
        """Wait for its end; return its status in words, and the result."""
        assert self.is_accepted, "the goal was rejected"
        reply = self._client.messages("result", goal=self._number, timeout=timeout)
        return reply.status, reply.result

    def cancel(self) -> Message:
        """Ask for its cancellation; return the response."""
        return self._client.messages("cancel_goal", goal=self._number, timeout=TIMEOUT)

    def feedback(self) -> list[Message]:
        """Return all feedback so far."""
        found: list[Message] = self._client.messages("feedback", goal=self._number)
        return found


class Topic:
    """A subscription that keeps every message."""

    def __init__(self, client: Client, name: str, number: int) -> None:
        self._client, self.name, self._number = client, name, number

    @property
    def count(self) -> int:
        """How many messages have come."""
        return int(self._client.request("count", subscription=self._number))

    def since(self, first: int) -> list[Message]:
        """Return the messages from a number on."""
        found: list[Message] = self._client.messages(
            "messages", subscription=self._number, since=first
        )
        return found

    @property
    def last(self) -> Message:
        """The newest message."""
        return self.since(-1)[0]

    def wait_for(
        self,
        condition: Callable[[Message], bool] = lambda message: True,
        *,
        since: int = 0,
        timeout: float = TIMEOUT,
    ) -> Message:
        """Return the first message, from number ``since``, that meets ``condition``."""
        seen = since

        def found() -> Message | None:
            nonlocal seen
            messages = self.since(seen)
            seen += len(messages)
            return next((one for one in messages if condition(one)), None)

        return until(found, f"a message on {self.name}", timeout)

    def wait_for_new(
        self, condition: Callable[[Message], bool], timeout: float = TIMEOUT
    ) -> Message:
        """Return the first message from now on that meets ``condition``."""
        return self.wait_for(condition, since=self.count, timeout=timeout)

    def next(self, n: int = 1) -> list[Message]:
        """Return the next ``n`` messages."""
        since = self.count
        until(lambda: self.count >= since + n, f"{n} messages on {self.name}")
        return self.since(since)[:n]


def as_message(value: Any) -> Any:
    """Return JSON's objects as messages."""
    if isinstance(value, dict):
        return SimpleNamespace(**{k: as_message(v) for k, v in value.items()})
    if isinstance(value, list) and value and isinstance(value[0], dict | list):
        return [as_message(one) for one in value]
    return value


_KINDS = {
    bool: (1, "bool_value"),
    int: (2, "integer_value"),
    float: (3, "double_value"),
    str: (4, "string_value"),
}
_ARRAYS = {
    bool: (6, "bool_array_value"),
    int: (7, "integer_array_value"),
    float: (8, "double_array_value"),
    str: (9, "string_array_value"),
}


def _to_value(value: Any) -> dict[str, object]:
    """Return a value as rcl_interfaces/ParameterValue."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        number, field = _ARRAYS[type(value[0])]
        value = list(value)
    else:
        number, field = _KINDS[type(value)]
    return {"type": number, field: value}


def _from_value(value: Message) -> Any:
    fields = dict([*_KINDS.values(), *_ARRAYS.values()])
    return getattr(value, fields[value.type]) if value.type else None
