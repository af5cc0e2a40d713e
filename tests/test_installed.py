"""What is installed from a wheel, alone and with each extra: every interface once."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest
from installation import Installation, build_wheel, extras_of, install
from kernel_sources import require_compiler
from ros import free_port
from ur_address import free_host

from tool0.cli import FAILED, OK

NEEDS = {
    "gym": "gymnasium",
    "collect": "gymnasium",
    "ray": "ray",
    "video": "av",
    "gpu": "warp",
}
"""Extra → what it brings."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    require_compiler()
    return build_wheel(tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def plain(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installation:
    return install(wheel, tmp_path_factory.mktemp("plain") / "venv")


@pytest.fixture(scope="module")
def recorded(plain: Installation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording, and one with a demonstration."""
    folder = tmp_path_factory.mktemp("recorded")
    words = "--headless --duration 0.3 --no-realtime --record one.mcap"
    assert_works(plain.run("tool0", "bringup", *words.split(), cwd=folder))
    program = (
        "import tool0\n"
        "with tool0.bringup(realtime=False) as robot:\n"
        "    robot.episodes.open('lift', task='lift')\n"
        "    robot.episodes.start()\n"
        "    robot.run(0.3)\n"
        "    robot.episodes.end('success')\n"
    )
    assert_works(plain.run("python", "-W", "error", "-c", program, cwd=folder))
    return folder


def assert_works(done: subprocess.CompletedProcess[str]) -> None:
    said = done.stdout + done.stderr
    assert done.returncode == OK, said
    assert "Traceback" not in said
    assert "starts again" not in said


def assert_refused(done: subprocess.CompletedProcess[str], shown: str) -> None:
    """It says in one line what is missing, before anything starts."""
    assert done.returncode == FAILED, done.stdout + done.stderr
    assert done.stdout == ""
    assert done.stderr.startswith("tool0: error: ")
    assert done.stderr.count("\n") == 1, done.stderr
    assert shown in done.stderr


def test_the_extras_are_those_that_are_tested(wheel: Path) -> None:
    assert set(extras_of(wheel)) == set(NEEDS)


def test_it_is_not_the_checkout(plain: Installation, tmp_path: Path) -> None:
    program = (
        "import tool0, sys; print(tool0.__file__); from tool0.kernel.library import "
        "kernel_status; print(kernel_status().reason)"
    )
    done = plain.run("python", "-c", program, cwd=tmp_path)
    where, reason, _ = done.stdout.split("\n")
    assert Path(where).is_relative_to(plain.folder)
    assert reason == ""


@pytest.mark.parametrize("interface", ["ros1", "ros2", "ur"])
def test_an_interface_works_or_says_what_is_missing(
    interface: str, plain: Installation, tmp_path: Path
) -> None:
    words = ["bringup", "--headless", "--duration", "0.3", f"--{interface}"]
    words += ["--name", f"installed-{interface}"]
    if interface == "ur":
        words += ["--ur-host", free_host()]
    if interface == "ros1":
        words += ["--roscore"]
    done = plain.run(
        "tool0", *words, cwd=tmp_path, ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}"
    )
    if interface == "ur" or done.returncode == OK:
        assert_works(done)
        assert interface[:2].upper() in done.stdout
    else:
        assert_refused(done, "ROS")


def test_the_urscript_that_the_greeting_names_is_there(
    plain: Installation, tmp_path: Path
) -> None:
    host = free_host()
    program = f"""
import socket, tool0
with tool0.bringup() as robot, socket.create_server(("127.0.0.1", 0)) as ours:
    with tool0.UrController(robot, tool0.UrOptions(host="{host}")) as ur:
        ur.wait()
        port = ours.getsockname()[1]
        with socket.create_connection(("{host}", 30002)) as script:
            text = f'socket_open("127.0.0.1", {{port}})\\nsocket_send_line(6 * 7)\\n'
            script.sendall(f"def answer():\\n{{text}}end\\n".encode())
            peer, _ = ours.accept()
            print(peer.recv(100).decode())
"""
    done = plain.run("python", "-c", program, cwd=tmp_path)
    assert_works(done)
    assert done.stdout.split() == ["42"]


def test_recordings_need_no_extra(
    plain: Installation, recorded: Path, tmp_path: Path
) -> None:
    file = str(recorded / "one.mcap")
    assert_works(plain.run("tool0", "log", file, cwd=tmp_path))
    replayed = plain.run("tool0", "replay", file, "--simulate", cwd=tmp_path)
    assert_works(replayed)
    assert "identical" in replayed.stdout
    table = ["export", file, "--output", "one.csv"]
    assert_works(plain.run("tool0", *table, cwd=tmp_path))
    assert (tmp_path / "one.csv").stat().st_size > 0


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        ("export one.mcap --format parquet --output {}/one.parquet", "pyarrow"),
        ("export one.mcap --format mp4 --output {}/one.mp4", "'.[video]'"),
        ("export lift --format lerobot --output {}/set", "'.[collect]'"),
        ("collect --task Reach --episodes 1 --folder {}/reach", "'.[collect]'"),
        ("collect --task Reach --episodes 1 --ray local --folder {}/r", "'.[collect]'"),
    ],
)
def test_what_needs_an_extra_says_so(
    words: str, shown: str, plain: Installation, recorded: Path, tmp_path: Path
) -> None:
    done = plain.run("tool0", *words.format(tmp_path).split(), cwd=recorded)
    assert_refused(done, shown)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("program", "shown"),
    [
        ("import tool0.gym", r"pip install '\.\[gym\]'"),
        ("import tool0; tool0.Batch(1, device='cuda')", r"pip install '\.\[gpu\]'"),
        ("from tool0.collect import collect; collect('Reach', 1, 'r')", r"\[collect\]"),
    ],
)
def test_a_program_gets_an_error_that_names_the_extra(
    program: str, shown: str, plain: Installation, tmp_path: Path
) -> None:
    done = plain.run("python", "-c", program, cwd=tmp_path)
    last = done.stderr.splitlines()[-1]
    assert re.fullmatch(r"tool0\.errors\.\w+Error: .*", last)
    assert re.search(shown, last)


@pytest.mark.parametrize("extra", NEEDS)
def test_an_extra_brings_what_it_is_for(
    extra: str, wheel: Path, recorded: Path, tmp_path: Path
) -> None:
    pytest.importorskip(NEEDS[extra], reason=f"{NEEDS[extra]} is not installed here")
    installed = install(wheel, tmp_path / "venv", extra)
    if extra == "gym":
        program = (
            "import gymnasium, tool0.gym\n"
            "env = gymnasium.make('tool0/Reach-v0')\n"
            "env.reset(seed=0); env.step(env.action_space.sample()); env.close()\n"
        )
        assert_works(installed.run("python", "-c", program, cwd=tmp_path))
    elif extra == "collect":
        words = "--task Reach --episodes 1 --workers 1 --format lerobot --json"
        done = installed.run("tool0", "collect", *words.split(), cwd=tmp_path)
        assert_works(done)
        assert json.loads(done.stdout)["episodes"] == 1
        for name, form in (("one.mcap", "parquet"), ("lift", "lerobot")):
            words = f"export {name} --format {form} --output {tmp_path}/{form}"
            assert_works(installed.run("tool0", *words.split(), cwd=recorded))
    elif extra == "video":
        words = f"export one.mcap --width 32 --height 24 --output {tmp_path}/one.mp4"
        done = installed.run("tool0", *words.split(), cwd=recorded)
        if done.returncode == OK:
            assert_works(done)
        else:
            assert_refused(done, "OpenGL")
    else:
        program = f"import {NEEDS[extra]}"
        assert_works(installed.run("python", "-c", program, cwd=tmp_path))
