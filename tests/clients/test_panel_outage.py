"""A simulator that was stopped and goes on, and silent peers: nothing moves."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from browser import comes_to_rest, eventually
from page import Message, Page, page_at

import tool0
from tool0.panel.server import Panel

ARM = "eff_joint_traj_controller"
PAN, LIFT = "shoulder_pan_joint", "shoulder_lift_joint"
FROZEN = 1.6
"""[wall s]: above what counts as frozen."""
STOPPING = 0.6
"""Within which every motion has come to rest [simulated s]: controllers ramp down in
0.5 s (stop_trajectory_duration)."""
STILL = 0.01
"""What joints may move after that, as they settle [rad]; unstopped, it is 0.08."""
JOG = {"twist": [0.0, 0.0, 0.05, 0.0, 0.0, 0.0], "acceleration": 2.0, "duration": 0.04}


@pytest.fixture(scope="module")
def server() -> Iterator[tuple[str, int]]:
    """Return the panel of ``tool0 bringup`` in a process of its own, and its number."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    command = [
        *(sys.executable, "-m", "tool0", "bringup", "--no-remote", "--no-open"),
        *("--panel-port", str(port)),
    ]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "TOOL0_PANEL_TOKEN": "secret"},
    ) as process:
        try:
            assert process.stdout is not None
            assert any(str(port) in line for line in process.stdout)
            yield f"http://127.0.0.1:{port}/?token=secret", process.pid
        finally:
            process.kill()


@contextmanager
def repeating(send: Callable[[int], None]) -> Iterator[None]:
    """Send the setpoints of a stream meanwhile, as a held button does."""
    is_over = threading.Event()

    def repeat() -> None:
        count = 0
        while not is_over.wait(0.016):
            send(count)
            count += 1

    sender = threading.Thread(target=repeat)
    sender.start()
    try:
        yield
    finally:
        is_over.set()
        sender.join()


def positions(page: Page, frame: Message) -> list[float]:
    return [page.position(joint, frame) for joint in (PAN, LIFT)]


def moves(watch: Page, since: list[float]) -> None:
    """Wait until the robot has moved."""
    watch.next(
        "state",
        lambda frame: (
            max(abs(q - p) for q, p in zip(positions(watch, frame), since, strict=True))
            > 0.01
        ),
    )


def stop(pid: int) -> None:
    """Stop a child, and wait until none of its threads runs."""
    os.kill(pid, signal.SIGSTOP)
    os.waitid(os.P_PID, pid, os.WSTOPPED)


def freeze(pid: int) -> None:
    stop(pid)
    try:
        time.sleep(FROZEN)  # the outage itself
    finally:
        os.kill(pid, signal.SIGCONT)


def rests(watch: Page) -> None:
    """Check that the robot comes to rest after an outage, and stays."""
    stopped = watch.next("notice", lambda notice: "stood still" in notice["text"])
    assert stopped["severity"] == "warning"
    end = stopped["time"] + STOPPING
    first = watch.next("state", lambda frame: frame["time"] > end)
    last = watch.next("state", lambda frame: frame["time"] > end + 1.0)
    before, after = positions(watch, first), positions(watch, last)
    assert after == pytest.approx(before, abs=STILL)


def go(page: Page, name: str) -> None:
    """Go to a pose by a new press, once the requests of an outage have been read."""
    eventually(
        lambda: page.request("go_to_pose", name=name, speed=1.0) is None,
        "a new request is carried out",
    )
    page.next("notice", lambda it: it["code"] == "goal_succeeded")


@pytest.mark.parametrize("kind", ["jog", "slider", "goal"])
def test_nothing_goes_on_after_the_simulator_was_frozen(
    server: tuple[str, int], kind: str
) -> None:
    """Nor does what peers sent meanwhile, or go on to send, move it."""
    url, pid = server
    with page_at(url) as page, page_at(url) as watch:
        go(watch, "ready")
        start = positions(watch, watch.next("state"))

        def send(count: int) -> None:
            if kind == "jog":
                page.send("speed_tool", **JOG)
            elif kind == "slider":
                wanted = {PAN: start[0] + 0.005 * count}
                page.send("steer_joints", controller=ARM, positions=wanted, speed=0.3)

        if kind == "jog":
            assert page.request("take_arm", by="panel") is None
        elif kind == "goal":
            assert page.request("go_to_pose", name="up", speed=0.1) is None
        with repeating(send):
            moves(watch, start)
            freeze(pid)
            rests(watch)
        go(watch, "ready")
        state = watch.next("state")
        assert positions(watch, state) == pytest.approx(start, abs=STILL)


def test_what_was_requested_of_a_frozen_simulator_is_not_carried_out(
    server: tuple[str, int],
) -> None:
    url, pid = server
    with page_at(url) as page, page_at(url) as watch:
        go(watch, "ready")
        stop(pid)
        try:
            late = page.start("go_to_pose", name="up")
            ramp = page.start("command_trajectory", controller=ARM)
            time.sleep(FROZEN)
        finally:
            os.kill(pid, signal.SIGCONT)
        reply = page.next("reply", lambda message: message["id"] == late)
        assert "stood still" in reply["error"]["message"]
        reply = page.next("reply", lambda message: message["id"] == ramp)
        assert "error" not in reply
        rests(watch)


def test_a_stream_that_was_silent_has_ended(panel: Panel, robot: tool0.Robot) -> None:
    """So what an outage of the network has held up moves nothing."""
    comes_to_rest(robot)
    with page_at(panel.url) as page, page_at(panel.url) as watch:
        start = positions(watch, watch.next("state"))
        jog = {**JOG, "timeout": 1.5}
        assert page.request("take_arm", by="panel") is None
        with repeating(lambda _: page.send("speed_tool", **jog)):
            moves(watch, start)
        eventually(lambda: robot.arm.motion.state.is_done, "the stream has ended")
        before = robot.joint_state.position
        with repeating(lambda _: page.send("speed_tool", **jog)):
            refused = page.next("reply", lambda reply: reply["id"] is None)
            assert "has ended" in refused["error"]["message"]
        assert robot.joint_state.position == pytest.approx(before, abs=STILL)
        assert page.request("stop_arm") is None  # a new press
        start = positions(watch, watch.next("state"))
        with repeating(lambda _: page.send("speed_tool", **jog)):
            moves(watch, start)
        assert page.request("return_arm") is None
