"""The server over its Unix socket: whatever a peer sends or does, the robot goes on."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import socket
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fresh_python
import pytest
from served import serving, use_folder

import tool0
from tool0.errors import ControlError, GoalTimeoutError, TransportError
from tool0.protocol.bus import GoalFinished, WasReset
from tool0.protocol.codec import PROTOCOL
from tool0.scene import Box, Compound, Pose
from tool0.server.lines import MAX_LINE
from tool0.server.server import Server
from tool0.server.session import MAX_BACKLOG

pytestmark = pytest.mark.slow

ARM = "eff_joint_traj_controller"
LONG = 30.0  # [wall s]; only a failing test waits so long


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(speed=2.0) as robot:
        yield robot


@pytest.fixture
def server(robot: tool0.Robot) -> Iterator[Server]:
    robot.resume()
    robot.emergency_stop(False)
    robot.reset()
    with serving(robot) as server:
        yield server


class Peer:
    """A client that can misbehave."""

    def __init__(self, folder: Path) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(LONG)
        self.socket.connect(str(folder / "tool0.sock"))
        self._lines = self.socket.makefile("rb")
        self.hello = self.receive()

    def send(self, message: object) -> None:
        line = message if isinstance(message, bytes) else json.dumps(message).encode()
        self.socket.sendall(line + b"\n")

    def receive(self) -> Any:
        line = self._lines.readline()
        return json.loads(line) if line else None

    def ask(self, method: str, **params: object) -> Any:
        self.send({"id": 7, "method": method, "params": params})
        while (answer := self.receive())["type"] != "reply":
            pass
        assert answer["id"] == 7
        return answer

    def close(self) -> None:
        self._lines.close()
        self.socket.close()


@pytest.fixture
def peer(server: Server, folder: Path) -> Iterator[Peer]:
    peer = Peer(folder)
    yield peer
    peer.close()


def test_the_socket_is_for_this_user_only_and_goes_with_the_server(
    robot: tool0.Robot, folder: Path
) -> None:
    with serving(robot):
        path = folder / "tool0.sock"
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert not path.exists()


STRANGER = """
import os, socket, sys
os.chdir(sys.argv[1])
os.setuid(12345)
peer = socket.socket(socket.AF_UNIX)
peer.connect("tool0.sock")
print(peer.recv(100))
"""


@pytest.mark.skipif(os.getuid() != 0, reason="only root has other users")
def test_a_program_of_another_user_is_turned_away(
    server: Server, folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder.chmod(0o711)  # as nobody does
    (folder / "tool0.sock").chmod(0o666)
    assert fresh_python.run(STRANGER, str(folder)) == "b''\n"
    assert "another user" in caplog.text
    folder.chmod(0o700)
    tool0.connect().close()


def test_it_greets_with_its_protocol(peer: Peer) -> None:
    assert peer.hello["type"] == "hello"
    assert peer.hello["protocol"] == PROTOCOL
    assert (peer.hello["pid"], peer.hello["mode"]) == (os.getpid(), "simulation")


@pytest.mark.slow
def test_an_endless_line_is_answered_and_ends_only_that_connection(
    peer: Peer, folder: Path
) -> None:
    with contextlib.suppress(OSError):  # the server may hang up before it has all
        peer.send(b"x" * (MAX_LINE + 10))
    error = peer.receive()["error"]
    assert error["type"] == "TransportError"
    assert f"longer than {MAX_LINE} bytes" in error["message"]
    assert peer.receive() is None
    other = Peer(folder)
    assert "result" in other.ask("read_snapshot")
    other.close()


def test_requests_of_one_connection_are_answered_in_order(peer: Peer) -> None:
    peer.ask("pause")
    peer.send(b"")  # an empty line is ignored
    for ident in range(50):
        peer.send({"id": ident, "method": "step"})
    assert [peer.receive()["id"] for _ in range(50)] == list(range(50))


@pytest.mark.parametrize("n_steps", [100, MAX_BACKLOG + 3])
def test_an_emergency_stop_waits_for_no_step_however_long(
    folder: Path, n_steps: int
) -> None:
    with tool0.bringup(paused=True) as robot, serving(robot):
        peer = Peer(folder)
        step = {"id": 1, "method": "step", "params": {"ticks": 1_000_000}}
        peer.socket.sendall((json.dumps(step) + "\n").encode() * n_steps)
        peer.send({"id": 2, "method": "emergency_stop"})
        while (reply := peer.receive())["id"] == 1:
            assert "wait" in reply["error"]["message"]  # more than may wait
        assert reply["result"] is None
        assert robot.snapshot.is_stopped
        peer.close()


def test_a_goal_is_followed_to_its_end_and_a_dead_peer_s_goal_goes_on(
    peer: Peer, robot: tool0.Robot
) -> None:
    params = {"positions": {"shoulder_pan_joint": 0.2}}
    (started,) = peer.ask("move_joints", **params)["result"]
    while (message := peer.receive())["type"] != "goal_finished":
        pass
    assert message["goal"] == started["goal"]
    assert message["outcome"]["status"] == "SUCCEEDED"
    (started,) = peer.ask("move_joints", positions={"shoulder_pan_joint": 0.0})[
        "result"
    ]
    peer.close()
    goal = robot.simulation.goals.find(started["goal"])
    assert goal.wait(LONG)
    assert goal.status.value == "SUCCEEDED"


def test_closing_ends_connections_and_waits(robot: tool0.Robot) -> None:
    robot.resume()
    with serving(robot) as server:
        remote = tool0.connect()
        point = tool0.TrajectoryPoint([0.0] * 6, time_from_start=1e6)
        goal = remote.controller(ARM).follow([point])
        failed = threading.Event()

        def wait() -> None:
            with pytest.raises(TransportError):
                goal.wait()
            failed.set()

        waiter = threading.Thread(target=wait)
        waiter.start()
        server.close()
        waiter.join(LONG)
        assert failed.is_set()
        with pytest.raises(TransportError):
            remote.pause()
        remote.close()


def test_a_stream_has_every_snapshot_and_events(
    server: Server, robot: tool0.Robot
) -> None:
    with tool0.connect() as remote:
        stream = remote.subscribe(rate=500.0)
        first = stream.following(LONG)
        assert first is not None
        times = [first.time]
        while len(times) < 300:
            snapshot = stream.following(LONG)
            assert snapshot is not None
            times.append(snapshot.time)
        steps = {round(1e3 * (b - a)) for a, b in itertools.pairwise(times)}
        assert steps == {2}
        assert snapshot.setpoints().keys() >= {"elbow_joint", "finger_joint"}
        remote.move_joints({"wrist_3_joint": 0.1})[0].wait(LONG)
        remote.reset()
        while not {GoalFinished, WasReset} <= set(map(type, stream.events)):
            assert stream.following(LONG) is not None
        stream.close()
    bus, reader = robot.simulation.bus, robot.subscribe()
    while bus.shortest_period < 0.008:  # the server closes its subscription soon
        assert reader.next(LONG) is not None


def test_the_remote_robot_does_what_the_local_one_does(
    server: Server, robot: tool0.Robot
) -> None:
    with tool0.connect() as remote:
        assert remote.controllers() == robot.controllers()
        assert remote.info == robot.info
        assert remote.description.urdf == robot.description.urdf
        assert list(remote.grippers) == list(robot.grippers)
        goal = remote.gripper.move(opening=0.04, speed=0.1, force=40.0)
        assert goal.wait(LONG).status is tool0.GoalStatus.SUCCEEDED
        assert remote.gripper.wait(LONG).motion == "at_target"
        assert remote.gripper.opening == pytest.approx(robot.gripper.opening, abs=1e-4)
        remote.pause()
        assert remote.arm.pose() == robot.arm.pose()
        assert remote.pose("tool0", "base_link") == robot.pose("tool0", "base_link")
        assert remote.arm.inverse_kinematics(
            remote.arm.pose()
        ) == robot.arm.inverse_kinematics(robot.arm.pose())
        assert remote.joint_state == robot.joint_state
        state = remote.controller(ARM).state
        assert state == robot.controller(ARM).state
        assert remote.force_torque.start(100.0) == pytest.approx(100.0)
        remote.force_torque.zero()
        remote.step(20)
        assert len(remote.force_torque.samples()) >= 2
        assert remote.force_torque.read() == robot.force_torque.read()
        cube = Box(size=(0.1, 0.1, 0.1))
        added = remote.scene.add("cube", cube, xyz=(0.0, 2.0, 0.0), mass=1.0)
        assert added == robot.scene["cube"]
        remote.scene.place("cube", (0.0, 3.0, 0.0), linear=(0.0, 0.0, 1.0))
        assert remote.scene.states == robot.scene.states
        remote.scene.remove("cube")
        pair = Compound(parts=((cube, Pose()), (cube, Pose(xyz=(0.1, 0.0, 0.0)))))
        assert remote.scene.add("pair", pair, xyz=(0.0, 2.0, 0.0)).geometry == pair
        assert remote.scene["pair"] == robot.scene["pair"]
        remote.scene.remove("pair")
        assert len(robot.scene) == 0
        assert remote.contacts() == robot.contacts()
        assert remote.summary().keys() == robot.summary().keys()
        with pytest.raises(ControlError):
            _ = remote.engine
        with pytest.raises(ControlError):
            remote.run(0.1)  # paused
        with pytest.raises(GoalTimeoutError):
            remote.move_joints({"elbow_joint": 1.0})[0].wait(0.01)
        remote.resume()
        remote.switch(stop=[ARM])
        remote.switch(start=["joint_group_eff_controller"])
        remote.controller("joint_group_eff_controller").command([0.0] * 6)
        remote.switch(start=[ARM], stop=["joint_group_eff_controller"])
