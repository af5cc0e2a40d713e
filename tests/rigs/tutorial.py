"""Follow a tutorial: run its commands in order, and compare what they print."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from document import Block, blocks, says
from promised import ROS2, require_ur_rtde, why_lacking
from reader import Reader
from ros2_domain import Domain
from ur_address import free_host

FOLDER = Path(__file__).parents[2] / "docs/tutorials"
NOT_RUN = {
    "make setup": "it makes the environment that runs this test",
    "source .venv/bin/activate": "this test has done so in its own way",
    "pip install '.[collect,video]'": "it changes the environment of this test",
    "pip install ur-rtde": "tests of ur_rtde need it, too",
    "tool0 ros2 install": "it downloads; tests of ROS 2 run what it installed",
    "rosdep install --from-paths src --ignore-src --rosdistro noetic -y": (
        "it needs Noetic and root; the keys are looked at where packages are tested"
    ),
    "catkin_make": "tests of the workspace build the packages, where there is catkin",
    "source devel/setup.bash": "catkin_make makes it",
    "rqt --standalone rqt_joint_trajectory_controller": (
        "a window of Noetic's; tests of ROS 1 speak to what it speaks to"
    ),
}
"""Command → why no test of a page runs it."""
FAILED = re.compile(r"(^|[: ])error: |^not free: ", re.MULTILINE)
"""In the output of a block whose last command ends with a status other than 0."""
SHORTER = {
    "STEPS, CHUNK, WIDTH = 2500": "STEPS, CHUNK, WIDTH = 30",
    "--episodes 200": "--episodes 6",
    "--episodes 50": "--episodes 2",
}
"""What takes long → what the test has instead."""
HOST = "127.0.0.1"
"""Of a robot on a page; those of tests have an address of their own."""
PANEL = "Panel: http://127.0.0.1:8085/"
"""Where no page of this kind is printed, none is served."""
FASTER = "--speed 10"
"""Of a simulation that no program of a UR or of ROS follows."""


class Follower:
    """Decides what of a page is run here, and how."""

    def __init__(self, page: Path) -> None:
        self.text = page.read_text(encoding="utf-8")
        self.host = free_host() if "--ur" in self.text else None
        self.left_out: list[str] = []

    def skips(self, command: str) -> bool:
        """Return whether this machine cannot run it, or the test does not."""
        if command in NOT_RUN:
            return True
        if (lacking := why_lacking(command)) is not None:
            self.left_out.append(lacking)
            return True
        return False

    def changed(self, text: str) -> str:
        """Return a command or a file so that it disturbs nobody and is soon done."""
        for long, short in SHORTER.items():
            text = text.replace(long, short)
        if self.host is not None:
            text = text.replace(HOST, self.host)
        if text.startswith("tool0 bringup"):
            if PANEL not in self.text:
                text = f"{text} --headless"
            if "--ur" in text.split():
                return f"{text} --ur-host {self.host}"
            if not {"--hardware", "--ros2"} & set(text.split()):
                return f"{text} {FASTER}"
        if text.startswith("roslaunch "):
            words = f'ROS_PACKAGE_PATH="$PWD/src" {text} --nodes'
            # gazebo_ros, which that includes, is on Noetic alone.
            return f"{words} start_gazebo:=false" if "tool0_gazebo" in words else words
        return text


def printed(page: Path) -> Iterator[tuple[Block, str | None]]:
    """Yield the blocks that are not outputs, each with the output that follows it."""
    found = blocks(page)
    for block, after in zip(found, [*found[1:], None], strict=True):
        if block.language != "text":
            is_output = after is not None and after.language == "text"
            yield block, after.text if after is not None and is_output else None


def follow(page: Path, runtime_folder: Path) -> None:
    """Do what an English page says, from its start to its end.

    The test is skipped at the end if this machine lacks something of the page.
    """
    follower = Follower(page)
    folder = Path(tempfile.mkdtemp(prefix=f"{page.stem}-", dir=runtime_folder))
    with ExitStack() as stack:
        variables = {}
        if "rtde_" in follower.text:
            require_ur_rtde()
        if "--ros2" in follower.text and (page.stem == "ros2" or ROS2 is not None):
            variables.update(stack.enter_context(Domain()).variables)
        reader = Reader(folder, follower.changed, variables)
        stack.enter_context(reader)
        for block, told in printed(page):
            fails = told is not None and FAILED.search(told) is not None
            output = reader.follows(block, follower.skips, fails=fails)
            if follower.host is not None:
                output = output.replace(follower.host, HOST)
            if told is not None:
                assert says(output, told), f"{block.text}\n{output}"
            if "roslaunch " in block.text:
                assert "/robot_state_publisher\n" in output or follower.left_out
    if follower.left_out:
        pytest.skip("; ".join(follower.left_out))
