"""Control updates over the Unix socket, received by the ROS 2 node's own connection."""

from __future__ import annotations

import logging
import queue
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from served import serving, use_folder
from tool0_ros2 import requests
from tool0_ros2.connection import (
    Connection,
    RequestFailedError,
)
from tool0_ros2.errors import TransportError
from waits import until

import tool0

LONG = 30.0  # [wall s]; only a failing test waits so long
ARM = "eff_joint_traj_controller"


FIELDS = ("joint_names", "position", "controllers", "is_paused")


def following(*more: str, **params: Any) -> requests.Request[None]:
    """Return a request for the newest states."""
    fields: Any = (*FIELDS, *more)
    return requests.subscribe(fields=fields, newest_only=True, **params)


class Listener:
    """A connection whose messages are kept."""

    def __init__(self) -> None:
        self.messages: queue.Queue[Any] = queue.Queue()
        self.end: queue.Queue[str] = queue.Queue()
        self.connection = Connection("tool0")
        self.connection.on_message = self.messages.put
        self.connection.on_end = self.end.put
        self.connection.start()

    def next(self, kind: str = "state") -> dict[str, Any]:
        while True:
            message = self.messages.get(timeout=LONG)
            if message["type"] == kind:
                return message

    def times(self, n: int) -> list[float]:
        return [self.next()["time"] for _ in range(n)]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup() as robot:
        yield robot


@pytest.fixture
def listener(robot: tool0.Robot) -> Iterator[Listener]:
    robot.resume()
    robot.set_speed(1.0)
    with serving(robot):
        listener = Listener()
        yield listener
        listener.connection.close()


@pytest.mark.slow
def test_every_update_comes_once_and_in_order(listener: Listener) -> None:
    listener.connection.call(following(rate=500.0))
    first = listener.next()
    times = [first["time"], *listener.times(200)]
    steps = [after - before for before, after in pairwise(times)]
    assert max(steps) == pytest.approx(0.002, abs=1e-6)
    assert min(steps) == pytest.approx(0.002, abs=1e-6)
    assert len(first["position"]) == len(first["joint_names"])
    assert {status["name"] for status in first["controllers"]} >= {ARM}
    assert "motions" not in first
    assert "command" not in first


def test_changes_in_between_delay_no_update(
    robot: tool0.Robot, listener: Listener
) -> None:
    robot.pause()
    robot.step(2 - robot.snapshot.tick % 2)
    listener.connection.call(following("control_boxes", rate=500.0))
    start = listener.next()["tick"]
    assert start % 2 == 0
    robot.step(1)
    robot.arm.control_box.set_digital_output(0, True)
    robot.step(1)
    ticks = [listener.next()["tick"], listener.next()["tick"]]
    robot.arm.control_box.set_digital_output(0, False)
    assert ticks == [start + 1, start + 2]  # the change, and what is due


def test_names_and_controllers_come_only_when_they_change(
    robot: tool0.Robot, listener: Listener
) -> None:
    listener.connection.call(following(rate=125.0))
    listener.next()
    assert not {"joint_names", "controllers"} & listener.next().keys()
    robot.pause()
    robot.switch(stop=[ARM])
    known: dict[str, Any] = {}
    while "controllers" not in known:
        known |= listener.next()
    states = {item["name"]: item["is_running"] for item in known["controllers"]}
    assert (known["is_paused"], states[ARM]) == (True, False)
    robot.switch(start=[ARM])


def test_motions_come_for_those_who_ask(listener: Listener) -> None:
    listener.connection.call(
        following("motions", "command", controllers=[ARM, "absent"])
    )
    message = listener.next()
    (name,) = message["motions"]
    motion = message["motions"][name]
    assert name == ARM
    assert [len(row) for row in motion["reference"]] == [6, 6, 6]
    for reference, feedback, error in zip(
        motion["reference"], motion["feedback"], motion["error"], strict=False
    ):
        differences = [a - b for a, b in zip(reference, feedback, strict=True)]
        assert error == pytest.approx(differences)
    assert motion["speed_scaling"] == 1.0
    assert len(message["command"]) == len(message["position"])


def test_fast_time_sends_fewer_updates(robot: tool0.Robot, listener: Listener) -> None:
    listener.connection.call(following(rate=500.0))
    listener.times(5)
    robot.set_speed(2.0)
    steps = [0.0]
    while steps != pytest.approx([0.004] * 5, abs=1e-6):  # it follows the new speed
        times = listener.times(6)
        steps = [after - before for before, after in pairwise(times)]


def test_streams_that_were_replaced_cost_nothing_any_more(
    robot: tool0.Robot, listener: Listener
) -> None:
    for _ in range(30):
        listener.connection.submit(following(rate=500.0))
    listener.connection.call(following(rate=500.0))
    listener.next()
    listener.connection.call(requests.Request("unsubscribe", {}))
    until(lambda: not robot.simulation.bus.has_subscribers, "no subscriber left")


def test_warnings_come_along_and_are_still_printed(
    listener: Listener, capsys: pytest.CaptureFixture[str]
) -> None:
    listener.connection.call(following(rate=125.0))
    listener.next()
    logging.getLogger("tool0.control").warning("the arm is %s", "cold")
    message = listener.next("log")
    assert (message["level"], message["message"]) == ("warning", "the arm is cold")
    logging.getLogger("tool0.ros2.node").warning("of the node")
    logging.getLogger("tool0.control").error("at last")
    assert listener.next("log")["message"] == "at last"


def test_those_who_ask_for_the_same_share_a_stream_that_begins_for_each(
    robot: tool0.Robot, listener: Listener
) -> None:
    listener.connection.call(following(rate=125.0))
    assert "joint_names" in listener.next()
    robot.pause()
    other = Listener()
    other.connection.call(following(rate=125.0))
    assert {"joint_names", "position"} <= other.next().keys()
    assert len(robot.simulation.bus._subscriptions) == 1
    listener.connection.call(requests.Request("unsubscribe", {}))
    robot.resume()
    assert "joint_names" not in other.next()
    other.connection.close()


def test_a_reset_is_reported(robot: tool0.Robot, listener: Listener) -> None:
    listener.connection.call(following(rate=500.0))
    listener.next()
    robot.reset()
    assert listener.next("reset")["time"] == 0.0
    assert listener.next()["time"] < 1.0


def test_goals_report_their_end_once(listener: Listener) -> None:
    call = listener.connection.call
    call(following(rate=125.0))
    ended: queue.Queue[Any] = queue.Queue()
    names = listener.next()["joint_names"]
    elbow = next(name for name in names if "elbow" in name)
    move: requests.Request[Any] = requests.Request(
        "move_joints", {"positions": {elbow: 0.1}}
    )
    (started,) = call(move)
    call(requests.cancel_goal(goal=started["goal"]))
    listener.connection.when_finished(started["goal"], ended.put)
    assert ended.get(timeout=LONG)["status"] == "PREEMPTED"
    call(requests.read_info())
    assert ended.empty()


def test_refusals_have_type_and_code(listener: Listener) -> None:
    with pytest.raises(RequestFailedError, match="nope") as caught:
        listener.connection.call(requests.unload_controller(name="nope"))
    assert caught.value.kind == "ControlError"
    with pytest.raises(RequestFailedError, match="NaN"):
        listener.connection.call(
            requests.command_joints(controller=ARM, values=[float("nan")])
        )
    listener.connection.post(requests.command_joints(controller=ARM, values=[0.0]))
    refusal = listener.next("reply")
    assert refusal["id"] is None
    assert ARM in refusal["error"]["message"]


def test_the_end_of_the_bringup_is_noticed(robot: tool0.Robot) -> None:
    with serving(robot):
        listener = Listener()
    assert listener.end.get(timeout=LONG) == "the bring-up has ended"
    with pytest.raises(RequestFailedError, match="ended"):
        listener.connection.call(requests.read_info())
    listener.connection.close()


@pytest.mark.parametrize("name", ["tool0", "../tool0", "x" * 70])
def test_without_a_bringup_there_is_no_connection(name: str) -> None:
    with pytest.raises(TransportError):
        Connection(name)


def test_a_folder_open_to_others_is_not_trusted(folder: Path) -> None:
    place = folder if folder.name == "tool0" else folder / "tool0"
    place.mkdir(exist_ok=True)
    place.chmod(0o777)
    (place / "tool0.sock").touch()
    with pytest.raises(TransportError, match="chmod 700"):
        Connection("tool0")
