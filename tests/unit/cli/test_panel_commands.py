"""`tool0 bringup` and `tool0 view` as a person calls them: where is the page?"""

import contextlib
import os
import pty
import re
import signal
import subprocess
import sys
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from socket import gethostname
from urllib.request import urlopen

import pytest
from page import TIMEOUT, page_at
from served import use_folder

from tool0.cli import FAILED, OK, main
from tool0.cli.options import PanelOptions
from tool0.cli.panel import show
from tool0.panel.address import Endpoint, open_endpoint

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


@pytest.fixture
def taken() -> Iterator[Endpoint]:
    endpoint = open_endpoint()
    yield endpoint
    endpoint.listener.close()


@contextmanager
def running(*words: str) -> Iterator[tuple["subprocess.Popen[str]", str]]:
    """Start a command and yield it with the address that it printed."""
    with subprocess.Popen(
        [sys.executable, "-W", "error", "-m", "tool0", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout is not None
        url = ""
        for line in program.stdout:
            if line.startswith("Panel: "):
                url = line.split()[1]
            if line.startswith("Ctrl-C"):
                break
        try:
            yield program, url
        finally:
            program.kill()


def end(program: "subprocess.Popen[str]") -> str:
    """Send Ctrl-C, and return what stands on standard error."""
    program.send_signal(signal.SIGINT)
    _, error = program.communicate(timeout=TIMEOUT)
    assert program.returncode == OK, error
    return error


def test_bringup_serves_the_panel_where_it_says() -> None:
    with running("bringup") as (program, url):
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", url)
        with page_at(url) as page:
            assert page.request("pause") is None
            error = end(program)
            assert page.close_code() == 1001
        assert "Traceback" not in error


def test_view_serves_a_robot_to_be_posed() -> None:
    with running("view", "--gripper", "none") as (program, url):
        with page_at(url) as page:
            assert page.view["robot"]["title"] == "ur5"
            assert page.view["robot"]["ground"] == -0.1
            page.send("pose_joints", positions={"elbow_joint": 1.0})
            page.wait_for_joint("elbow_joint", 1.0, within=1e-6)
        assert "Traceback" not in end(program)


def test_a_chosen_port_needs_no_token() -> None:
    with running("view", "--panel-port", "0") as (program, url):
        assert "token" not in url
        with page_at(url) as page:
            assert page.request("reset") is None
        assert end(program) == ""


def test_an_address_for_other_machines_is_warned_of_and_needs_the_token() -> None:
    options = ("--panel-host", "0.0.0.0", "--panel-port", "0")
    with running("view", *options) as (program, url):
        assert "?token=" in url
        with page_at(url.replace(gethostname(), "127.0.0.1", 1)) as page:
            assert page.request("reset") is None
        assert "anyone with its address and token" in end(program)


def test_headless_serves_no_panel_and_loads_no_web_server() -> None:
    code = (
        "import sys; from tool0.cli import main; "
        "main('bringup --headless --no-realtime --duration 0 --no-summary'.split());"
        "heavy = {'starlette', 'uvicorn', 'websockets', 'asyncio', 'ssl'};"
        "print(sorted(heavy & sys.modules.keys()))"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert "Panel" not in done.stdout


def test_with_a_json_summary_the_address_goes_to_standard_error(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = "bringup --no-realtime --duration 0.01 --json"
    assert main(line.split()) == OK
    out, error = capsys.readouterr()
    assert out.startswith("{")
    assert out.count("\n") == 1
    assert "Panel: http://127.0.0.1:" in error


def test_a_port_that_is_taken_is_told_before_anything_starts(
    taken: Endpoint, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bringup", "--panel-port", str(taken.port)]) == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert f"port {taken.port} of 127.0.0.1 is taken; choose another" in error
    assert error.count("\n") == 1


def test_another_port_is_found_if_the_usual_one_is_taken(taken: Endpoint) -> None:
    with running("view") as (program, url):
        assert f":{taken.port}/" not in url
        with urlopen(url) as response:
            assert response.status == 200
        end(program)


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def test_a_browser_opens_only_before_a_person_with_a_desktop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.delenv("DISPLAY", raising=False)
    show("no desktop", PanelOptions(), Terminal())
    monkeypatch.setenv("DISPLAY", ":0")
    show("no terminal", PanelOptions(), StringIO())
    show("not wanted", PanelOptions(open=False), Terminal())
    assert opened == []
    thread = show("http://here/", PanelOptions(), Terminal())
    assert thread is not None
    thread.join(TIMEOUT)
    assert opened == ["http://here/"]


def test_a_demo_is_repeated_by_enter() -> None:
    terminal, standard_input = pty.openpty()
    with (
        os.fdopen(terminal, "wb", buffering=0) as keyboard,
        subprocess.Popen(
            [sys.executable, "-m", "tool0", "demo", "pick", "--no-open"],
            stdin=standard_input,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as program,
        contextlib.ExitStack() as cleanup,
    ):
        cleanup.callback(program.kill)  # of no effect on one that has ended
        os.close(standard_input)
        assert program.stdout is not None
        assert program.stderr is not None
        url = program.stderr.readline().removeprefix("Panel: ").strip()
        program.stderr.readline()
        with page_at(url) as page:
            assert page.request("view_shown") is None
            assert page.request("set_speed", factor=10.0) is None
            keyboard.write(b"\n")
            for _ in range(2):
                assert "in the bin after" in program.stdout.readline()
                assert program.stdout.readline().startswith("1 of 1 in the bin; ")
                assert "Enter repeats the demo" in program.stderr.readline()
            program.send_signal(signal.SIGINT)
        assert program.wait(30.0) == OK


def test_a_demo_waits_for_a_page_and_stays_for_it() -> None:
    with (
        subprocess.Popen(
            [sys.executable, "-W", "error", "-m", "tool0", "demo", "pick", "--no-open"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as program,
        contextlib.ExitStack() as cleanup,
    ):
        cleanup.callback(program.kill)  # of no effect on one that has ended
        assert program.stdout is not None
        assert program.stderr is not None
        url = program.stderr.readline().removeprefix("Panel: ").strip()
        assert program.stderr.readline() == (
            "It starts when a browser shows that page.\n"
        )
        with page_at(url) as page:
            names = {item["name"] for item in page.next("scene")["objects"]}
            assert {"cube", "bin.floor"} <= names
            assert page.request("view_shown") is None
            assert "in the bin after" in program.stdout.readline()
            assert program.stdout.readline().startswith("1 of 1 in the bin; ")
            assert (
                program.stderr.readline() == "The panel stays open; Ctrl-C ends it.\n"
            )
            assert page.request("pause") is None
            program.send_signal(signal.SIGINT)
            assert page.close_code() == 1001
        assert program.wait(TIMEOUT) == OK
        assert "Traceback" not in program.stderr.read()
