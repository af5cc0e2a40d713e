"""Servers that restart, several browsers, and pages of other origins."""

import http.server
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browser import Tab, comes_to_rest, eventually, time_passes
from page import page_at

import tool0
from conftest import OpenTab
from tool0.panel.server import Panel

CONNECTED = "[data-testid=connection][data-state=open]"
LOST = "[data-testid=connection][data-state=lost]"
READY = "[data-testid=scene][data-ready=true]"
NEAR = 0.03
"""[rad]"""


@contextmanager
def bringup_at(port: int) -> Iterator[subprocess.Popen[str]]:
    """Run ``tool0 bringup`` in a process of its own, its panel ready."""
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
            yield process
        finally:
            process.kill()


STOP_IS_INSIDE = """(width) => {
    const stop = document.querySelector("[data-testid=estop]").getBoundingClientRect();
    return window.innerWidth === width && stop.right <= width && stop.bottom < 60;
}"""
"""Condition: the page has a width, and the whole stop button is in its first line."""


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port: int = listener.getsockname()[1]
        return port


def test_a_page_comes_back_after_the_server_restarts(open_tab: OpenTab) -> None:
    port = free_port()
    url = f"http://127.0.0.1:{port}/?token=secret"
    with bringup_at(port):
        tab = open_tab(url)
        tab.expected = ["ERR_CONNECTION_REFUSED"]
        tab.see(READY)  # what is still to be fetched then would be refused
        tab.drive()
    tab.see(LOST)
    tab.get("connection-banner").wait_for()
    for width in (1440, 1024, 960, 700, 390, 360):  # nothing pushes the stop out
        tab.page.set_viewport_size({"width": width, "height": 800})
        tab.page.wait_for_function(STOP_IS_INSIDE, arg=width)
    with bringup_at(port):
        tab.see(CONNECTED)
        tab.get("connection-banner").wait_for(state="hidden")
        # driving has ended, and begins again only by hand
        assert not tab.get("enable-toggle").is_checked()
        tab.drive()
        tab.send_joint("elbow_joint", 1.4)
        with page_at(url) as other:
            other.wait_for_joint("elbow_joint", 1.4, NEAR)
        tab.shows_joint("elbow_joint", 1.4, NEAR)
        tab.close()


def test_a_page_tells_that_the_server_is_silent(open_tab: OpenTab) -> None:
    port = free_port()
    with bringup_at(port) as process:
        tab = open_tab(f"http://127.0.0.1:{port}/?token=secret")
        tab.see(READY)
        process.send_signal(signal.SIGSTOP)
        try:
            tab.text("connection", "no data for")
            tab.get("estop").click()
            tab.text("stop-requested", "Stop requested")
        finally:
            process.send_signal(signal.SIGCONT)
        tab.get("estop-banner").wait_for()
        tab.see(CONNECTED)
        tab.close()


def test_a_button_that_is_held_while_the_server_is_silent_moves_nothing_after_that(
    open_tab: OpenTab,
) -> None:
    port = free_port()
    url = f"http://127.0.0.1:{port}/?token=secret"
    with bringup_at(port) as process, page_at(url) as watch:
        tab = open_tab(url)
        tab.drive()
        tab.get("tool-toggle").click()
        button = tab.get("jog-z-plus")
        button.scroll_into_view_if_needed()

        def lift() -> float:
            return watch.position("shoulder_lift_joint", watch.next("state"))

        start = lift()
        button.hover()
        tab.page.mouse.down()
        eventually(lambda: abs(lift() - start) > 0.01, "the arm moves")
        process.send_signal(signal.SIGSTOP)
        try:
            tab.get("silence-banner").wait_for()
            tab.page.wait_for_timeout(1000)  # of the outage
            assert not tab.get("enable-toggle").is_checked()
        finally:
            process.send_signal(signal.SIGCONT)
        tab.see(CONNECTED)
        tab.text("driving-state", "no data")
        end = watch.next("notice", lambda it: "stood still" in it["text"])["time"]
        watch.next("state", lambda frame: frame["time"] > end + 0.5)
        rest = lift()
        watch.next("state", lambda frame: frame["time"] > end + 2.0)
        assert abs(lift() - rest) < 0.01  # while the button is still held
        tab.page.mouse.up()
        tab.drive()
        button.hover()
        tab.page.mouse.down()
        eventually(lambda: abs(lift() - rest) > 0.02, "a new press moves it")
        tab.page.mouse.up()
        tab.close()


def test_a_paused_simulation_is_not_silent(
    panel: Panel, open_tab: OpenTab, robot: tool0.Robot
) -> None:
    robot.pause()
    tab = open_tab(panel.url)
    tab.see(READY)
    tab.see(CONNECTED)
    tab.page.evaluate(
        """() => {
            window.states = [];
            const badge = document.querySelector("[data-testid=connection]");
            new MutationObserver(() => states.push(badge.dataset.state))
                .observe(badge, {attributes: true});
        }"""
    )
    tab.page.wait_for_timeout(2000.0)
    assert tab.page.evaluate("states") == []


def test_a_page_without_the_token_is_told_so(
    open_tab: OpenTab, robot: tool0.Robot
) -> None:
    with Panel(robot, port=0, token="secret") as panel:
        tab = open_tab()
        tab.expected = ["401", "HTTP Authentication failed"]
        tab.page.goto(panel.url.partition("?")[0])
        tab.see("[data-testid=connection][data-state=refused]")
        tab.text("connection-banner", "token")
        assert tab.errors
        tab.close()


def test_two_browsers_see_and_drive_the_same_robot(
    panel: Panel, open_tab: OpenTab
) -> None:
    one, other = open_tab(panel.url), open_tab(panel.url)
    one.text("connection", "2")
    one.drive()
    one.send_joint("elbow_joint", 1.4)
    for tab in (one, other):
        tab.shows_joint("elbow_joint", 1.4, NEAR)
    other.drive()
    other.send_joint("elbow_joint", 1.2)
    for tab in (one, other):
        tab.shows_joint("elbow_joint", 1.2, NEAR)
    one.text("driving-state", "another client")
    other.get("estop").click()
    one.get("estop-banner").wait_for()


ATTACK = """async ([target, steer]) => {
    const results = {};
    results.socket = await new Promise((resolve) => {
        const socket = new WebSocket(`ws://${target}/ws`);
        socket.onopen = () => { socket.send(steer); };
        socket.onmessage = () => resolve("open");
        socket.onerror = () => resolve("refused");
    });
    for (const mode of ["cors", "no-cors"]) {
        results[mode] = await fetch(`http://${target}/ws`, {
            method: "POST", mode, body: steer,
        }).then((answer) => answer.type, () => "refused");
    }
    results.read = await fetch(`http://${target}/robot.urdf`)
        .then((answer) => answer.text(), () => "refused");
    return results;
}"""
STEER = (
    '{"method": "steer_joints", "params": {"controller": "eff_joint_traj_controller", '
    '"positions": {"elbow_joint": 0.5}, "speed": 1.0}}'
)


@pytest.fixture
def elsewhere(tmp_path: Path) -> Iterator[str]:
    """A page of another origin: another server on this machine."""
    (tmp_path / "index.html").write_text("<title>elsewhere</title>", encoding="utf-8")

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *args: object, **options: object) -> None:
            super().__init__(*args, directory=str(tmp_path), **options)  # type: ignore[arg-type]

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        thread.join()


def attack(tab: Tab, panel: Panel) -> dict[str, str]:
    target = panel.url.removeprefix("http://").rstrip("/")
    results: dict[str, str] = tab.page.evaluate(ATTACK, [target, STEER])
    return results


def test_a_page_of_another_origin_cannot_drive_the_robot(
    panel: Panel, open_tab: OpenTab, robot: tool0.Robot, elsewhere: str
) -> None:
    comes_to_rest(robot)
    before = robot.joint_state.position["elbow_joint"]
    tab = open_tab()
    tab.page.goto(elsewhere)
    assert set(attack(tab, panel).values()) == {"refused"}
    time_passes(robot, 0.5)
    assert robot.joint_state.position["elbow_joint"] == pytest.approx(before, abs=1e-3)
    tab.errors.clear()
    tab.requested.clear()

    # the same from the panel's own page does drive it: the attempt was a real one
    tab.page.goto(panel.url)
    assert attack(tab, panel)["socket"] == "open"
    eventually(
        lambda: abs(robot.joint_state.position["elbow_joint"] - 0.5) < NEAR,
        "the arm moves",
    )
    tab.errors.clear()
