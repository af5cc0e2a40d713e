"""The Python blocks of the how-to guides and of the reference run, page by page.

The blocks of a page are one program: each starts with the names of those before it.  A
``text`` block after one says what it prints.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from document import Block, blocks, says

DOCS = Path(__file__).parents[2] / "docs"
TIMEOUT = 120.0  # [wall s]


@dataclass(frozen=True)
class Setting:
    """What the reader of a page has before its first block."""

    before: str = ""
    """Python that runs first."""
    files: dict[str, str] = field(default_factory=dict)
    instead: dict[str, str] = field(default_factory=dict)
    """What the page says → what is run, such as fewer copies."""
    not_run: dict[int, str] = field(default_factory=dict)
    """Number of a block among those of Python → why it is not run."""


ROBOT = "import tool0; robot = tool0.bringup(realtime=False)"

SETTINGS: dict[str, Setting] = {
    "bringup": Setting(),
    "force-torque": Setting(before=ROBOT),
    "gripper": Setting(before=ROBOT),
    "motion": Setting(before=ROBOT),
    "python-recipes": Setting(not_run={1: "it needs a bring-up in another process"}),
}


def python_blocks(page: Path) -> list[tuple[Block, Block | None]]:
    """Return the blocks of Python, each with what it prints, if the page says so."""
    found = blocks(page)
    after = [*found, None][1:]
    return [
        (block, told if told is not None and told.language == "text" else None)
        for block, told in zip(found, after, strict=True)
        if block.language == "python"
    ]


PAGES = [
    page
    for page in sorted([*DOCS.glob("how-to/*.md"), *DOCS.glob("reference/*.md")])
    if page.stem in SETTINGS
]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_blocks_run_and_print_what_the_page_says(
    page: Path, tmp_path: Path
) -> None:
    setting = SETTINGS.get(page.stem, Setting())
    for name, text in setting.files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    found = python_blocks(page)
    run = [n for n in range(len(found)) if n not in setting.not_run]
    program = [setting.before]
    for n in run:
        program += [f"print('<<<{n}>>>')", found[n][0].text]
    source = "\n".join(program)
    for said, done in setting.instead.items():
        assert said in source
        source = source.replace(said, done)
    (tmp_path / "page.py").write_text(source, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "page.py"],
        cwd=tmp_path,
        env={**os.environ, "XDG_RUNTIME_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    printed = dict(zip(run, done.stdout.split("<<<")[1:], strict=True))
    for n in run:
        told = found[n][1]
        if told is not None:
            assert says(printed[n], told.text), printed[n]
