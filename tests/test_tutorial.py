"""What the tutorial says: its commands run, they print that, in both languages."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from document import Block, blocks, says
from promised import absent, require_engine, require_ros
from ros import free_port
from ros2_domain import Domain

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "docs/tutorials/ros1.md", ROOT / "docs/tutorials/ros1.zh-CN.md"]
READMES = [ROOT / "README.md", ROOT / "README.zh-CN.md"]
BLOCKS = blocks(PAGES[0])
LANGUAGES = {"sh", "text", "xml", "yaml"}

NOT_RUN = {
    "make setup": "it makes the environment that runs this test",
    "source .venv/bin/activate": "this test has done so in its own way",
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
"""Command → why no test of this page runs it."""
FINDS = (
    "tool0 check my_controllers.yaml gazebo_controller.yaml",
    "tool0 check ros2_controllers.yaml",
)
"""What ends with status 1, since something is wrong."""
SHORT = ("--headless", "--no-realtime", "--duration", "0.5")
XACRO = """#!/bin/sh
file=$1; shift
exec tool0 describe urdf --robot "$file" --args "$@"
"""
"""roslaunch calls it; a machine without Noetic has none that finds our packages."""


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Reader:
    reader = Reader(tmp_path_factory.mktemp("reader"))
    reader.types("tool0 workspace catkin_UR5")  # so that each test can run alone
    return reader


class Reader:
    """A person who has typed the files of the page and now types its commands."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        programs = folder / ".bin"
        programs.mkdir()
        (programs / "xacro").write_text(XACRO)
        (programs / "xacro").chmod(0o755)
        folder.chmod(0o700)
        path = [str(programs), str(Path(sys.executable).parent), os.environ["PATH"]]
        self.environ = {
            **{k: v for k, v in os.environ.items() if k != "DISPLAY"},
            "PATH": os.pathsep.join(path),
            "XDG_RUNTIME_DIR": str(folder),  # no other bringup is seen there
            "ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}",
            "ROS_HOME": str(folder / ".ros"),
            "ROS_LOG_DIR": str(folder / ".ros/log"),
        }
        for block in BLOCKS:
            if block.language in ("xml", "yaml"):
                (folder / block.title).write_text(block.text, encoding="utf-8")

    def types(self, command: str, *, status: int | bool = 0) -> str:
        """Return what the command prints."""
        done = subprocess.run(
            ["bash", "-c", command],
            cwd=self.folder,
            env=self.environ,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=60,
            check=False,
        )
        assert done.returncode == status, f"{command}\n{done.stdout}"
        return done.stdout

    @contextmanager
    def bringup(self) -> Iterator[None]:
        """Have one run in another terminal."""
        with subprocess.Popen(
            ["tool0", "bringup", "--headless"],
            cwd=self.folder,
            env=self.environ,
            stdout=subprocess.PIPE,
            text=True,
        ) as process:
            try:
                assert process.stdout is not None
                assert "is up in mujoco" in process.stdout.readline()
                yield
            finally:
                process.send_signal(signal.SIGINT)
                process.communicate(timeout=30)


def steps() -> list[tuple[Block, Block | None]]:
    """Return the blocks of commands, each with what it prints, if that is told."""
    told = [*BLOCKS[1:], None]
    return [
        (block, after if after is not None and after.language == "text" else None)
        for block, after in zip(BLOCKS, told, strict=True)
        if block.language == "sh"
    ]


def shortened(command: str) -> str:
    """Return the command so that it ends by itself and opens nothing."""
    if command.startswith("tool0 bringup"):
        return f"{command} {shlex.join(SHORT)}"
    if command.startswith("roslaunch "):
        words = f'ROS_PACKAGE_PATH="$PWD/catkin_UR5/src" {command} --nodes'
        # gazebo_ros, which that includes, is on Noetic alone.
        return f"{words} start_gazebo:=false" if "tool0_gazebo" in words else words
    return command


def run(reader: Reader, command: str) -> str:
    if command in NOT_RUN or command.startswith("cd "):
        return ""
    if "--engine gazebo" in command:
        require_engine("gazebo")
    if "--ros1" in command:
        require_ros()
    if command.startswith("roslaunch ") and shutil.which("roslaunch") is None:
        absent("ros1", "there is no roslaunch here")
    if command == "tool0 bringup --ros2":
        with Domain() as domain:
            variables = " ".join(f"{k}={v}" for k, v in domain.variables.items())
            return reader.types(f"{variables} {shortened(command)}")
    output = reader.types(shortened(command), status=command in FINDS)
    assert "roslaunch" not in command or "/robot_state_publisher\n" in output
    return output


@pytest.mark.parametrize(
    ("block", "told"), steps(), ids=[block.commands()[0] for block, _ in steps()]
)
def test_the_commands_run_and_print_what_the_page_says(
    block: Block, told: Block | None, reader: Reader
) -> None:
    if block.title == "second-terminal":
        with reader.bringup():
            output = "".join(run(reader, line) for line in block.commands())
    else:
        output = "".join(run(reader, line) for line in block.commands())
    if told is not None:
        assert says(output, told.text), output


def test_what_is_not_run_is_on_the_page() -> None:
    lines = [line for block, _ in steps() for line in block.commands()]
    assert NOT_RUN.keys() <= set(lines)
    assert "setup:" in (ROOT / "Makefile").read_text()


def test_only_commands_for_noetic_are_marked_so() -> None:
    programs = {"rosdep", "catkin_make", "roslaunch", "rqt"}
    for block, _ in steps():
        used = {line.split()[0] for line in block.commands()} & programs
        assert (block.title == "noetic") == bool(used), block.text


@pytest.mark.parametrize("pages", [PAGES, READMES], ids=["tutorial", "readme"])
def test_both_languages_have_the_same_commands(pages: list[Path]) -> None:
    english, chinese = map(blocks, pages)
    assert [(b.language, b.title) for b in english] == [
        (b.language, b.title) for b in chinese
    ]
    for ours, theirs in zip(english, chinese, strict=True):
        if ours.language in ("", "sh"):  # comments are translated
            words = [
                [shlex.split(c, comments=True) for c in b.commands()]
                for b in (ours, theirs)
            ]
            assert words[0] == words[1]
        else:
            assert ours.text == theirs.text


def test_both_readmes_name_the_same_commands() -> None:
    ours, theirs = (
        [
            re.findall("`([^`]+)`", row.split(" | ")[0])
            for row in page.read_text(encoding="utf-8").splitlines()
            if row.startswith("| `tool0")
        ]
        for page in READMES
    )
    assert ours
    assert ours == theirs


def test_every_block_of_the_tutorial_is_known() -> None:
    assert {block.language for block in BLOCKS} == LANGUAGES
    for block in BLOCKS:
        if block.language in ("xml", "yaml"):
            assert block.title, block.text


@pytest.mark.parametrize("page", [*PAGES, READMES[1]], ids=lambda page: page.name)
def test_links_of_the_page_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)]+)\)", text)
    assert targets
    for target in targets:
        file, _, section = target.partition("#")
        if "://" in target:
            continue
        assert not file or (page.parent / file).exists(), target
        if not file:
            assert section in map(anchor, re.findall(r"^#+ (.+)$", text, re.M)), target


def anchor(heading: str) -> str:
    """Return what GitHub calls a heading."""
    kept = re.sub(r"[^\w\- ]", "", heading.lower())
    return kept.replace(" ", "-")
