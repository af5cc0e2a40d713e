"""The process of the ROS 2 node: a stand-in for it starts, reports, dies and ends."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from waits import until

from tool0.errors import RosUnavailableError
from tool0.installation.ros2.installation import Ros2
from tool0.ros2 import node
from tool0.ros2.node import Ros2Node
from tool0.ros2.options import Ros2Options

READY = 'print(\'{"ready": true, "node": "/tool0"}\', flush=True)\n'
ARGUMENTS = (
    "import os, sys; open(os.environ['SEEN'], 'a').write(f'{sys.argv[1:]}\\n')\n"
)
FOR_EVER = "import time; time.sleep(1000)\n"
LOG = "print('[WARN] [17.5] [controller_manager]: no such controller', flush=True)\n"

Program = Callable[[str], Path]


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Program:
    """Return what makes a program the node; it returns the file with its arguments."""
    folder = tmp_path / "stand_in"
    package = folder / "stand_in"
    package.mkdir(parents=True)
    seen = tmp_path / "seen"
    ros2 = Ros2(
        kind="own",
        distro="kilted",
        prefix=tmp_path,
        python=Path(sys.executable),
        environment={**os.environ, "SEEN": str(seen), "PYTHONPATH": "/other"},
    )
    monkeypatch.setattr(node, "find_ros2", lambda: ros2)
    monkeypatch.setattr(node, "NODE_FOLDER", folder)

    def write(source: str) -> Path:
        (package / "__main__.py").write_text(ARGUMENTS + source)
        return seen

    return write


def test_it_waits_for_the_node_and_passes_options(program: Program) -> None:
    seen = program(READY + FOR_EVER)
    options = Ros2Options(ns="robot1", domain=7, tf_rate=20.0)
    with Ros2Node("bench", options) as ros2:
        assert ros2.wait() == "/tool0"
        assert ros2.domain == 7
        pid = ros2.pid
        assert pid is not None
        os.kill(pid, 0)
    words = seen.read_text()
    assert "'--name', 'bench', '--ns', 'robot1'" in words
    assert "'--tf-rate', '20.0'" in words
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.slow
def test_a_node_that_dies_is_reported_and_starts_again(
    program: Program, caplog: pytest.LogCaptureFixture
) -> None:
    seen = program(READY + "print('out of luck'); sys.exit(3)\n")
    with Ros2Node("bench") as ros2:
        ros2.wait()
        until(lambda: len(seen.read_text().splitlines()) > 1, "another start")
    assert "ended with status 3; it starts again in 0.5 s" in caplog.text
    assert "out of luck" in caplog.text


def test_a_node_that_cannot_start_says_why(program: Program) -> None:
    program("print('no module named rclpy'); sys.exit(1)\n")
    with Ros2Node("bench") as ros2, pytest.raises(RosUnavailableError) as caught:
        ros2.wait()
    assert "status 1" in str(caught.value)
    assert "no module named rclpy" in str(caught.value)


def test_its_log_is_logged(program: Program, caplog: pytest.LogCaptureFixture) -> None:
    program(LOG + READY + FOR_EVER)
    with caplog.at_level(logging.INFO), Ros2Node("bench") as ros2:
        ros2.wait()
    (record,) = caplog.records
    assert record.getMessage() == "ROS 2 [controller_manager]: no such controller"
    assert record.levelno == logging.WARNING


def test_without_ros_2_there_is_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node, "find_ros2", lambda: None)
    with pytest.raises(RosUnavailableError, match="tool0 ros2 install"):
        Ros2Node("bench")
