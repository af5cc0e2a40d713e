import json
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fake_robot import ABORTED, ARM, FakeRobot
from served import serving, use_folder
from tool0.interfaces.socket.methods import CALLS, GOALS
from tool0.interfaces.socket.server import RemoteServer

from tool0.api.address import Claim
from tool0.errors import TransportError
from tool0.interfaces.server.unix_socket import MAX_LINE
from tool0.requests.codec import PROTOCOL

VISITOR = """
import json, socket, sys
peer = socket.socket(socket.AF_UNIX)
peer.connect(sys.argv[1])
lines = peer.makefile("rw")
for ident, method, params in json.loads(sys.argv[2]):
    print(json.dumps({"id": ident, "method": method, "params": params}), file=lines)
    lines.flush()
    print(lines.readline().strip(), flush=True)
sys.stdin.read()
"""
FOLLOW = {"controller": "arm_controller", "points": [], "joint_names": list(ARM)}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


@pytest.fixture
def robot() -> FakeRobot:
    return FakeRobot(outcome=None)


@pytest.fixture
def server(robot: FakeRobot) -> Iterator[RemoteServer]:
    with serving(robot) as server:
        yield server


class Visitor:
    """A client that can misbehave."""

    def __init__(self, folder: Path, *, polite: bool = True) -> None:
        self.peer = socket.socket(socket.AF_UNIX)
        self.peer.settimeout(10.0)
        self.peer.connect(str(folder / "tool0.sock"))
        self._lines = self.peer.makefile("rb")
        if polite:
            assert self.ask("hello", protocol=PROTOCOL)["result"]["pid"] == os.getpid()

    def send(self, data: bytes) -> None:
        self.peer.sendall(data)

    def answer(self) -> Any:
        line = self._lines.readline()
        return json.loads(line) if line else None

    def ask(self, method: str, **params: object) -> Any:
        self.send(json.dumps({"id": 7, "method": method, "params": params}).encode())
        self.send(b"\n")
        answer = self.answer()
        assert answer["id"] == 7
        return answer

    def close(self) -> None:
        self._lines.close()
        self.peer.close()


@pytest.fixture
def visitor(server: RemoteServer, folder: Path) -> Iterator[Visitor]:
    visitor = Visitor(folder)
    yield visitor
    visitor.close()


def test_the_socket_is_for_this_user_only_and_goes_with_the_server(
    robot: FakeRobot, folder: Path
) -> None:
    with serving(robot):
        assert (folder / "tool0.sock").stat().st_mode & 0o777 == 0o600
    assert list(folder.iterdir()) == []


def test_the_first_request_must_be_hello(server: RemoteServer, folder: Path) -> None:
    visitor = Visitor(folder, polite=False)
    assert "hello" in visitor.ask("sim.pause")["error"]["message"]
    assert "result" in visitor.ask("hello", protocol=PROTOCOL)
    assert "result" in visitor.ask("sim.pause")
    visitor.close()


def test_another_protocol_is_refused(server: RemoteServer, folder: Path) -> None:
    visitor = Visitor(folder, polite=False)
    error = visitor.ask("hello", protocol=PROTOCOL + 1)["error"]
    assert error["type"] == "TransportError"
    assert f"protocol {PROTOCOL}, the client {PROTOCOL + 1}" in error["message"]
    visitor.close()


@pytest.mark.parametrize(
    "line",
    [
        b"{not json}",
        b"[1, 2]",
        b"\xff\xfe",
        b"{}",
        b'{"id": null, "method": "state"}',
        b'{"id": true, "method": "state"}',
        b'{"id": 1}',
        b'{"id": 1, "method": 5}',
        b'{"id": 1, "method": "state", "params": [1]}',
        b'{"id": 1, "method": "state", "parms": {}}',
        b'{"id": 1, "method": "sim.step", "params": {"ticks": -1}}',
        b'{"id": 1, "method": "sim.step", "params": {"tiks": 1}}',
        b'{"id": 1, "method": "__init__"}',
        b'{"id": 1, "method": "goal.wait", "params": {"goal": 99}}',
        b'{"id": 1, "method": "controller.follow", "params": {"controller": "x"}}',
        b"[" * 100_000,
    ],
)
def test_malformed_input_is_answered_and_harms_nothing(
    line: bytes, robot: FakeRobot, visitor: Visitor
) -> None:
    visitor.send(line + b"\n")
    assert visitor.answer()["error"]["message"]
    assert robot.calls == []
    assert visitor.ask("state")["result"]["time"] == robot.time


def test_an_unknown_method_names_the_nearest(visitor: Visitor) -> None:
    message = visitor.ask("sim.pase")["error"]["message"]
    assert message == "unknown method 'sim.pase'; did you mean 'sim.pause'?"


def test_a_fault_of_the_robot_reaches_the_peer_and_the_server_lives(
    robot: FakeRobot, visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken() -> None:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(robot, "reset", broken)
    assert "ZeroDivisionError" in visitor.ask("sim.reset")["error"]["message"]
    assert "result" in visitor.ask("state")


def test_an_endless_line_is_answered_and_ends_only_that_visit(
    robot: FakeRobot, visitor: Visitor, folder: Path
) -> None:
    visitor.send(b"x" * MAX_LINE)
    answer = visitor.answer()
    assert f"longer than {MAX_LINE} bytes" in answer["error"]["message"]
    assert visitor.answer() is None
    other = Visitor(folder)
    assert other.ask("state")["result"]["time"] == robot.time
    other.close()


def test_empty_lines_are_passed_over(visitor: Visitor) -> None:
    visitor.send(b"\n \r\n")
    assert "result" in visitor.ask("state")


def test_a_visitor_may_wait_and_ask_at_once(robot: FakeRobot, visitor: Visitor) -> None:
    goal = visitor.ask("controller.follow", **FOLLOW)["result"]["goal"]
    request = {"id": "w", "method": "goal.wait", "params": {"goal": goal}}
    visitor.send(json.dumps(request).encode() + b"\n")
    assert visitor.ask("goal.status", goal=goal)["result"]["status"] == "ACTIVE"
    robot.goals[0].goal.finish(ABORTED)
    answer = visitor.answer()
    assert answer["id"] == "w"
    assert answer["result"]["error_code"] == ABORTED.error_code


def test_a_visitor_that_dies_is_forgotten_and_its_goal_goes_on(
    robot: FakeRobot, server: RemoteServer, folder: Path
) -> None:
    requests = [
        [1, "hello", {"protocol": PROTOCOL}],
        [2, "controller.follow", FOLLOW],
    ]
    other = subprocess.Popen(
        [sys.executable, "-c", VISITOR, folder / "tool0.sock", json.dumps(requests)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert other.stdout is not None
    assert json.loads(other.stdout.readline())["result"]["protocol"] == PROTOCOL
    assert json.loads(other.stdout.readline())["result"]["goal"] == 1
    other.kill()
    other.communicate()
    visitor = Visitor(folder)
    assert visitor.ask("state")["result"]["time"] == robot.time
    assert not robot.goals[0].status.is_terminal
    # Goals belong to a connection: nobody else can touch this one.
    assert "no goal 1" in visitor.ask("goal.cancel", goal=1)["error"]["message"]
    visitor.close()


def test_waiting_threads_end_with_the_visitor(
    robot: FakeRobot, server: RemoteServer, folder: Path
) -> None:
    visitor = Visitor(folder)
    goal = visitor.ask("controller.follow", **FOLLOW)["result"]["goal"]
    request = {"id": 8, "method": "goal.wait", "params": {"goal": goal}}
    visitor.send(json.dumps(request).encode() + b"\n")
    assert visitor.ask("goal.status", goal=goal)["result"]["status"] == "ACTIVE"
    waiting = [t for t in threading.enumerate() if t.name.startswith("tool0-remote-")]
    assert {t.name for t in waiting} == {"tool0-remote-peer", "tool0-remote-wait"}
    visitor.close()
    for thread in waiting:
        thread.join(timeout=10.0)
        assert not thread.is_alive()


def test_too_many_waits_are_refused(visitor: Visitor) -> None:
    goal = visitor.ask("controller.follow", **FOLLOW)["result"]["goal"]
    request = {"id": 8, "method": "goal.wait", "params": {"goal": goal}}
    visitor.send((json.dumps(request).encode() + b"\n") * 65)
    assert "waits are in progress" in visitor.answer()["error"]["message"]
    assert "result" in visitor.ask("state")


def test_a_visitor_may_be_idle_whatever_the_default_of_sockets_is(
    server: RemoteServer, folder: Path
) -> None:
    socket.setdefaulttimeout(0.01)
    try:
        visitor = Visitor(folder)
        time.sleep(0.05)  # no event tells of a time-out that does not come
        assert "result" in visitor.ask("sim.pause")
        visitor.close()
    finally:
        socket.setdefaulttimeout(None)


def test_closing_hangs_up_on_everyone(robot: FakeRobot, folder: Path) -> None:
    server = RemoteServer(robot, Claim("tool0"))
    visitors = [Visitor(folder) for _ in range(3)]
    server.close()
    server.close()
    for visitor in visitors:
        assert visitor.answer() is None
        visitor.close()
    assert "tool0-remote" not in {thread.name for thread in threading.enumerate()}


def test_a_second_bringup_of_the_name_is_refused_and_the_first_serves_on(
    visitor: Visitor,
) -> None:
    with pytest.raises(TransportError, match=rf"pid {os.getpid()}"):
        Claim("tool0")
    assert "result" in visitor.ask("state")


def test_every_method_can_be_called(robot: FakeRobot, visitor: Visitor) -> None:
    params: dict[str, dict[str, object]] = {
        "controllers.load": {"name": "a"},
        "controllers.unload": {"name": "a"},
        "controller.query_state": {"controller": "arm_controller"},
        "controller.follow": FOLLOW,
        "gripper.move": {"opening": 0.04},
        "camera.image": {"name": "eye"},
        "arm.move_to": {"xyz": [0.4, 0, 0.3]},
        "arm.move_linear": {"xyz": [0.4, 0, 0.3]},
        "scene.add": {"name": "a", "kind": "sphere", "radius": 0.1},
        "scene.remove": {"name": "can"},
        "scene.place": {"name": "can", "xyz": [1, 2, 3]},
    }
    for method in (*CALLS, *GOALS):
        answer = visitor.ask(method, **params.get(method, {}))
        assert "result" in answer, (method, answer)
