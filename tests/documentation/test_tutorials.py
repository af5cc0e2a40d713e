"""The tutorials: their commands run in order and print what the pages say."""

from __future__ import annotations

from pathlib import Path

import pytest
from document import blocks
from reader import OTHER_MACHINE, SAVED
from tutorial import FOLDER, NOT_RUN, SHORTER, follow

CHINESE = sorted(FOLDER.glob("*.zh-CN.md"))
ENGLISH = [page.with_name(page.name.replace(".zh-CN", "")) for page in CHINESE]
FOLLOWED = [page for page in ENGLISH if page.stem != "real-arm"]
"""That one is followed alone: tests/clients/test_real_arm_tutorial.py."""
LANGUAGES = {"sh", "text", *SAVED}


@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", FOLLOWED, ids=lambda page: page.stem)
def test_a_page_can_be_followed_from_its_start_to_its_end(
    page: Path, runtime_folder: Path
) -> None:
    follow(page, runtime_folder)


def test_what_is_not_run_or_shortened_is_on_a_page() -> None:
    found = [block for page in ENGLISH for block in blocks(page)]
    text = "\n".join(block.text for block in found)
    lines = {c for block in found if block.language == "sh" for c in block.commands()}
    assert NOT_RUN.keys() <= lines
    assert all(long in text for long in SHORTER)
    assert "setup:" in (FOLDER.parents[1] / "Makefile").read_text()


def test_only_commands_for_noetic_are_marked_so() -> None:
    programs = {"rosdep", "catkin_make", "roslaunch", "rqt"}
    for page in ENGLISH:
        for block in blocks(page):
            if block.language == "sh":
                used = {line.split()[0] for line in block.commands()} & programs
                assert (block.title == OTHER_MACHINE) == bool(used), block.text


@pytest.mark.parametrize("page", ENGLISH, ids=lambda page: page.stem)
def test_every_block_of_a_tutorial_is_known(page: Path) -> None:
    found = blocks(page)
    assert {block.language for block in found} <= LANGUAGES
    files = [block.title for block in found if block.language in SAVED]
    assert all(files)
    assert len(files) == len(set(files))
