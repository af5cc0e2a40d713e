"""The commands of the how-to guides and of the reference run, page by page.

A reader follows each page from its start to its end in a folder of their own.
Bring-ups that no other command of the page uses end at once.  A ``text`` block after
commands says what they print; one with the title ``example`` has other numbers.
"""

from __future__ import annotations

import os
import re
import shlex
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from document import Block, blocks, says
from promised import require_ros, why_lacking
from reader import FIRST, SAVED, Reader
from ros import Ros
from ros2_domain import Domain
from shell_scenarios import NOT_RUN, SCENARIOS, Scenario
from ur_address import free_host

from tool0.cli import COMMANDS, form_and_readers
from tool0.cli.parsing import parse

DOCS = Path(__file__).parents[2] / "docs"
SECOND = "second-terminal"
BACKGROUND = "background"
"""Where a bring-up runs that the page takes for granted."""
ENDS_AT_ONCE = "--headless --no-realtime --duration 0.1 --json"
NAMED_ELSE = "--name short-lived"
"""So that it can run beside one that the page takes for granted."""
IN_REAL_TIME = {"--ur", "--ros1", "--ros2", "--hardware"}
"""Other programs follow such a simulation."""
HOST = "127.0.0.1"
"""Of a robot on a page; those of tests have an address of their own."""
N_PAGES = 20


def shell_blocks(page: Path) -> list[Block]:
    return [block for block in blocks(page) if block.language == "sh"]


PAGES = [
    page
    for page in sorted([*DOCS.glob("how-to/*.md"), *DOCS.glob("reference/*.md")])
    if not page.stem.endswith(".zh-CN") and shell_blocks(page)
]


class Follower:
    """Decides what of a page is run here, and how."""

    def __init__(self, scenario: Scenario, host: str) -> None:
        self._scenario, self._host = scenario, host
        self._brought_up: set[str] = set()
        self.left_out: list[str] = []
        self.is_used = False
        """Whether the next command is a bring-up that later commands use."""

    def skips(self, command: str) -> bool:
        """Return whether this machine cannot run it, or the test does not."""
        if command.startswith((*NOT_RUN,)):
            return True
        if command.startswith("tool0 bringup") and not self.is_used:
            if words_of(command) in self._brought_up:
                return True
            self._brought_up.add(words_of(command))
        if (lacking := why_lacking(command)) is not None:
            self.left_out.append(lacking)
            return True
        return False

    def changed(self, text: str) -> str:
        """Return a command or a file so that it disturbs nobody and is soon done."""
        for said, instead in self._scenario.instead.items():
            text = text.replace(said, instead)
        text = text.replace(HOST, self._host)
        if text.startswith("tool0 bringup"):
            text = words_of(text)
            if "--ur" in text.split() and "--ur-host" not in text:
                text = f"{text} --ur-host {self._host}"
            if not self.is_used:
                name = "" if "--name" in text else NAMED_ELSE
                return f"{text} {ENDS_AT_ONCE} {name}"
            if IN_REAL_TIME & {*text.split()}:
                return f"{text} --headless"
            return f"{text} --headless --speed {self._scenario.speed}"
        if text.startswith("tool0 demo "):
            return f"{words_of(text)} --headless"
        if text.startswith("tool0 record ") and "--episodes" not in text:
            return f"{words_of(text)} --duration 1"
        if text.startswith("roslaunch "):
            words = f'ROS_PACKAGE_PATH="$HOME/catkin_ur5/src" {text} --nodes'
            # gazebo_ros, which that includes, is on Noetic alone.
            return f"{words} start_gazebo:=false" if "tool0_gazebo" in words else words
        return text


def words_of(command: str) -> str:
    """Return a command without its comment."""
    return re.sub(r"\s+#\s.*$", "", command).strip()


def sh(command: str, title: str) -> Block:
    return Block("sh", title, command)


def steps(page: Path) -> Iterator[tuple[Block, str | None, bool]]:
    """Yield blocks of commands, what each prints, and whether it serves the next."""
    found = [
        block for block in blocks(page) if block.language in ("sh", "text", *SAVED)
    ]
    for block, *rest in (found[n:] for n in range(len(found))):
        if block.language != "sh":
            continue
        told = None
        if rest and rest[0].is_output:
            told = rest[0].text
        elif rest and (rest[0].language, rest[0].title) == ("text", "example"):
            told = re.sub(r"\b\d[\d.]*", "…", rest[0].text)
        others = [other.title for other in rest if other.language == "sh"]
        yield block, told, block.title != SECOND and others[:1] == [SECOND]


@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_commands_run_and_print_what_the_page_says(
    page: Path, runtime_folder: Path
) -> None:
    scenario = SCENARIOS.get(page.stem, Scenario())
    text = page.read_text(encoding="utf-8")
    folder = Path(tempfile.mkdtemp(prefix=f"{page.stem}-", dir=runtime_folder))
    host = free_host()
    follower = Follower(scenario, host)
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    variables = {"HOME": str(folder), "XDG_CACHE_HOME": cache}
    with ExitStack() as stack:
        if "--ros1" in text:
            require_ros()
            variables["ROS_MASTER_URI"] = stack.enter_context(Ros()).uri
        if "--ros2" in text and page.stem == "ros2":
            variables |= stack.enter_context(Domain()).variables
        reader = Reader(folder, follower.changed, variables)
        stack.enter_context(reader)
        for name, content in scenario.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content, encoding="utf-8")

        def types(command: str, title: str, *, is_used: bool = False) -> str:
            follower.is_used = is_used
            fails = words_of(command) in scenario.fails
            block = sh(command, title)
            return reader.follows(block, follower.skips, fails=fails)

        for block in blocks(page):
            if block.language in SAVED and block.title:
                reader.follows(block, follower.skips)
        for command in scenario.before:
            types(command, FIRST)
        served = None
        for number, (block, told, serves) in enumerate(steps(page)):
            wanted = scenario.during.get(number)
            if wanted != served:
                types(wanted or "true", BACKGROUND, is_used=wanted is not None)
                served = wanted
            commands = block.commands()
            output = "".join(
                types(
                    command,
                    block.title or FIRST,
                    is_used=serves and command == commands[-1],
                )
                for command in commands
            )
            if told is not None:
                assert says(output, told), f"{block.text}\n{output}"
            if block.title == "noetic":
                assert "/robot_state_publisher\n" in output or follower.left_out
    if follower.left_out:
        pytest.skip("; ".join(follower.left_out))


def all_commands() -> set[str]:
    return {
        words_of(command)
        for page in PAGES
        for block in shell_blocks(page)
        for command in block.commands()
    }


def test_what_is_not_run_is_on_a_page() -> None:
    for start in NOT_RUN:
        assert any(line.startswith(start) for line in all_commands()), start
    assert SCENARIOS.keys() <= {page.stem for page in PAGES}
    assert len(PAGES) >= N_PAGES


@pytest.mark.parametrize(
    "command",
    sorted(
        line
        for line in all_commands()
        if line.startswith("tool0 ") and line.startswith((*NOT_RUN,))
    ),
)
def test_commands_that_are_not_run_are_understood(
    command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.cli.parsing._made", lambda form, values: form)
    _, name, *words = [word for word in shlex.split(command) if word != "&"]
    form, readers = form_and_readers(name)
    assert parse(form, name, words, readers, COMMANDS[name][1])
