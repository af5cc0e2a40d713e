"""A client in ROS 2, told what to do: one JSON request a line in, one reply a line out.

It runs under ROS 2's Python, which is not the one of the tests, and lives long: to
import rclpy and to discover a robot takes seconds.  Messages are JSON objects; times
and durations are numbers [s].
"""

from __future__ import annotations

import contextlib
import importlib
import json
import re
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

SEND_TIMEOUT = 30.0
"""For the executor's thread to be free [s]."""
POLL_PERIOD = 0.005
"""Between two looks for a peer [s]."""
DEPTH = 10_000
"""Of a subscription's queue: none of a test's messages is dropped here."""
TIMES = ("builtin_interfaces/Time", "builtin_interfaces/Duration")
STATUS = ("unknown", "accepted", "executing", "canceling")
STATUS += ("succeeded", "canceled", "aborted")
Message = Any


# --- messages ---


def find(kind: str) -> Any:
    """Return the class of ``package/msg/Name``, also for services and actions."""
    package, folder, name = kind.split("/")
    return getattr(importlib.import_module(f"{package}.{folder}"), name)


def build(kind: Any, data: Any) -> Message:
    """Return a message with the named fields."""
    message = kind()
    types = message.get_fields_and_field_types()
    for name, value in data.items():
        setattr(message, name, _value(types[name], value))
    return message


def _value(kind: str, value: Any) -> Any:
    if kind in TIMES:
        nanoseconds = round(value * 1e9)
        sec, nanosec = divmod(nanoseconds, 1_000_000_000)
        return find(kind.replace("/", "/msg/"))(sec=sec, nanosec=nanosec)
    array = re.fullmatch(r"sequence<([^,>]+)(?:, *\d+)?>|(.+)\[\d+\]", kind)
    if array:
        return [_value(array[1] or array[2], one) for one in value]
    if "/" in kind:
        return build(find(kind.replace("/", "/msg/")), value)
    if kind in ("float", "double"):
        return float(value)
    return bytes([value]) if kind == "octet" else value


def plain(value: Any) -> Any:
    """Return a message as JSON has it."""
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
        if set(names) == {"sec", "nanosec"}:
            return value.sec + value.nanosec * 1e-9
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, (str, bool, int, float)):
        return value
    if isinstance(value, bytes):
        return value[0] if len(value) == 1 else list(value)
    if hasattr(value, "tolist"):  # of array or numpy
        return value.tolist()
    return [plain(one) for one in value]


# --- the client ---


class Worker:
    """An executor in a thread of its own.

    Entities are made, and requests are sent, in this thread: no response is looked at
    before its request is noted.  In another thread, rclpy's ActionClient drops a
    response that comes while it notes the request (github.com/ros2/rclpy/issues/1123;
    in rclpy 9.1.2 without a warning, see pull request 1532).
    """

    def __init__(self, node: Node) -> None:
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return what ``function`` returns in the thread."""
        done: Future[Any] = Future()

        def run() -> None:
            try:
                done.set_result(function(*arguments))
            except Exception as error:
                done.set_exception(error)

        self._executor.create_task(run)
        return done.result(SEND_TIMEOUT)

    def join(self) -> None:
        """Wait for its end, after that of rclpy."""
        self._thread.join(5.0)

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()


class Goal:
    """One goal of an action, from its response on."""

    def __init__(self, worker: Worker, client: ActionClient, message: Message) -> None:
        self._worker = worker
        self.feedback: list[Message] = []
        self._future = worker.call(
            client.send_goal_async,
            message,
            lambda one: self.feedback.append(one.feedback),
        )
        self._result: Any = None

    def response(self, timeout: float) -> bool:
        """Return whether it was accepted."""
        self.handle = finished(self._future, timeout, "a response to the goal")
        if self.handle.accepted:
            self._result = self._worker.call(self.handle.get_result_async)
        return bool(self.handle.accepted)

    def cancel(self, timeout: float) -> Any:
        """Ask for its cancellation; return the response."""
        future = self._worker.call(self.handle.cancel_goal_async)
        return finished(future, timeout, "a response to the cancellation")

    def result(self, timeout: float) -> Any:
        return finished(self._result, timeout, "the result of the goal")

    @property
    def has_ended(self) -> bool:
        return bool(self._result.done())


class Client:
    """The operations: each public method is one."""

    def __init__(self, node: Node, worker: Worker) -> None:
        self._node, self._worker = node, worker
        self._goals: list[Goal] = []
        self._received: list[list[Message]] = []
        self._subscriptions: list[Any] = []
        self._made: dict[tuple[str, ...], Any] = {}

    def _once(self, *key: str, make: Callable[[], Any]) -> Any:
        if key not in self._made:
            self._made[key] = self._worker.call(make)
        return self._made[key]

    def send_goal(self, action: str, kind: str, goal: Any, timeout: float) -> Any:
        """Send a goal and wait for the response."""
        client = self._once(
            "action",
            action,
            make=lambda: ActionClient(self._node, find(kind), action),
        )
        if not client.wait_for_server(timeout_sec=timeout):
            raise TimeoutError(f"no action server {action}")
        sent = Goal(self._worker, client, build(find(kind).Goal, goal))
        self._goals.append(sent)
        return {"goal": len(self._goals) - 1, "accepted": sent.response(timeout)}

    def cancel_goal(self, goal: int, timeout: float) -> Any:
        """Ask for its cancellation; return the response."""
        return plain(self._goals[goal].cancel(timeout))

    def has_ended(self, goal: int) -> bool:
        """Return whether the goal has a result."""
        return self._goals[goal].has_ended

    def result(self, goal: int, timeout: float) -> Any:
        """Wait for the goal's status and result."""
        answer = self._goals[goal].result(timeout)
        return {"status": STATUS[answer.status], "result": plain(answer.result)}

    def feedback(self, goal: int) -> Any:
        """Return all feedback that has come."""
        return [plain(one) for one in list(self._goals[goal].feedback)]

    def subscribe(self, topic: str, kind: str, latched: bool, reliable: bool) -> int:
        """Keep all messages of a topic; return the number of the subscription."""
        received: list[Message] = []
        profile = QoSProfile(
            depth=DEPTH,
            durability=durability(latched),
            reliability=ReliabilityPolicy.RELIABLE
            if reliable
            else ReliabilityPolicy.BEST_EFFORT,
        )
        subscription = self._worker.call(
            self._node.create_subscription,
            *(find(kind), topic, received.append, profile),
        )
        self._subscriptions.append(subscription)
        self._received.append(received)
        return len(self._received) - 1

    def unsubscribe(self, subscription: int) -> None:
        """Receive no more."""
        self._worker.call(
            self._node.destroy_subscription, self._subscriptions[subscription]
        )

    def count(self, subscription: int) -> int:
        """Return how many messages have come."""
        return len(self._received[subscription])

    def messages(self, subscription: int, since: int) -> Any:
        """Return those from a number on; with -1, the last one if there is one."""
        return [plain(one) for one in self._received[subscription][since:]]

    def publish(self, topic: str, kind: str, message: Any, latched: bool) -> None:
        """Publish one message, as soon as somebody subscribes."""
        profile = QoSProfile(depth=10, durability=durability(latched))
        publisher = self._once(
            "publisher",
            topic,
            make=lambda: self._node.create_publisher(find(kind), topic, profile),
        )
        wait(lambda: publisher.get_subscription_count() > 0, 30.0, f"one of {topic}")
        publisher.publish(build(find(kind), message))

    def call(self, service: str, kind: str, request: Any, timeout: float) -> Any:
        """Return the response of a service."""
        client = self._once(
            "service",
            service,
            make=lambda: self._node.create_client(find(kind), service),
        )
        if not client.wait_for_service(timeout_sec=timeout):
            raise TimeoutError(f"no service {service}")
        message = build(find(kind).Request, request)
        future = self._worker.call(client.call_async, message)
        return plain(finished(future, timeout, f"a response of {service}"))

    def nodes(self) -> list[str]:
        """Return the full names of all nodes."""
        found = self._node.get_node_names_and_namespaces()
        return sorted(f"{space.rstrip('/')}/{name}" for name, space in found)

    def topics(self) -> dict[str, Sequence[str]]:
        """Return topic → types."""
        return dict(self._node.get_topic_names_and_types())

    def services(self) -> dict[str, Sequence[str]]:
        """Return service → types."""
        return dict(self._node.get_service_names_and_types())

    def publishers(self, topic: str) -> Any:
        """Return node and quality of service of each publisher."""
        return [
            {
                "node": f"{one.node_namespace.rstrip('/')}/{one.node_name}",
                "type": one.topic_type,
                "reliable": one.qos_profile.reliability == ReliabilityPolicy.RELIABLE,
                "latched": one.qos_profile.durability
                == DurabilityPolicy.TRANSIENT_LOCAL,
            }
            for one in self._node.get_publishers_info_by_topic(topic)
        ]


def durability(latched: bool) -> DurabilityPolicy:
    if latched:
        return DurabilityPolicy.TRANSIENT_LOCAL
    return DurabilityPolicy.VOLATILE


def wait(condition: Callable[[], bool], timeout: float, what: str) -> None:
    """Wait until ``condition`` is true [s]."""
    deadline = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"{what}: not within {timeout:g} s")
        time.sleep(POLL_PERIOD)


def finished(future: Any, timeout: float, what: str) -> Any:
    """Wait for a future's result [s]."""
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    if not done.wait(timeout):
        raise TimeoutError(f"{what}: not within {timeout:g} s")
    return future.result()


def main() -> None:
    """Execute requests until standard input ends."""
    rclpy.init()
    node = Node("client")
    worker = Worker(node)
    client = Client(node, worker)
    print("{}", flush=True)
    for line in sys.stdin:
        operation, arguments = json.loads(line)
        try:
            reply = {"value": getattr(client, operation)(**arguments)}
        except Exception as error:
            reply = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(reply), flush=True)
    rclpy.shutdown()
    worker.join()


if __name__ == "__main__":
    main()
