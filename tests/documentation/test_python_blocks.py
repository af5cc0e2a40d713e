"""The Python blocks of the how-to guides and of the reference run, page by page.

The blocks of a page are one program: each starts with the names of those before it.  A
``text`` block after one says what it prints.  A block with a title is a file that the
reader saves.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from document import Block, blocks, says
from promised import require_engine, require_gl, require_ur_rtde
from ros import Bringup
from ur_address import free_host

DOCS = Path(__file__).parents[2] / "docs"
TIMEOUT = 240.0
"""For one page, on a busy machine [wall s]."""
HOST = "HOST"
"""In a setting: an address of the test's own."""


@dataclass(frozen=True)
class Setting:
    """What the reader of a page has before its first block."""

    before: str = ""
    """Python that runs first."""
    bringup: tuple[str, ...] | None = None
    """Options of a bring-up in another process."""
    files: Mapping[str, str] = field(default_factory=dict)
    instead: Mapping[str, str] = field(default_factory=dict)
    """What the page says → what is run, such as fewer copies."""
    not_run: Mapping[int, str] = field(default_factory=dict)
    """Number of a block among those of Python → why it is only compiled."""
    needs: tuple[Callable[[], object], ...] = ()
    """What skips the page where a program is absent."""


def file_of(page: str, title: str) -> str:
    """Return a file that the reader has saved from another page."""
    (found,) = (b.text for b in blocks(DOCS / page) if b.title == title)
    return found


UR = ("--ur", "--arm", "ur5e", "--ur-host", HOST, "--ur-active-gripper", "--speed", "4")
LOCAL = {'"127.0.0.1"': f'"{HOST}"'}
WORLD = """<sdf version="1.6"><world name="default">
<include><uri>model://ground_plane</uri></include></world></sdf>"""

MY_GRIPPER = """\
import shutil, tool0
config = f"{tool0.__path__[0]}/ros_packages/tool0_description/config"
shutil.copytree(f"{config}/grippers/hande", "my_gripper")
"""
"""What the reader of the page has typed before."""

SETTINGS: dict[str, Setting] = {
    "own-robot": Setting(before=MY_GRIPPER),
    "batch": Setting(
        instead={
            "Batch(256": "Batch(4",
            "(256, 6)": "(4, 6)",
            '4096, device="cuda"': '4, device="cpu"',
        },
        not_run={4: "PyTorch is not among the packages for tests"},
    ),
    "cameras": Setting(needs=(require_gl,)),
    "collect": Setting(instead={'"Lift", 1000': '"Lift", 2', "workers=4": "workers=1"}),
    "gazebo": Setting(
        files={"my.world": WORLD}, needs=(lambda: require_engine("gazebo"),)
    ),
    "gym": Setting(instead={"num_envs=64": "num_envs=4", ">= 64": ">= 4"}),
    "hardware": Setting(
        bringup=(*UR[:-2], "--dt", "0.002"),
        instead={
            '"192.168.1.10"': f'"{HOST}"',
            '"20195500123"': "box.state.link.serial_number",
        },
    ),
    "panel-protocol": Setting(
        before="""from itertools import islice
import tool0
robot = tool0.bringup()
panel = tool0.Panel(robot)
""",
        instead={
            '"ws://127.0.0.1:8085/ws"': 'panel.url.replace("http", "ws") + "ws"',
            "in socket:": "in islice(socket, 9):",
        },
    ),
    "policies": Setting(
        files={"my_policy.py": file_of("how-to/collect.md", "my_policy.py")},
        instead={"range(100)": "range(1)"},
    ),
    "programs": Setting(bringup=("--scene", "table_and_bin", "--speed", "10")),
    "python-recipes": Setting(
        bringup=("--name", "name", "--paused"),
        instead={"robot = tool0.connect()  #": 'tool0.connect("name").close()  #'},
        needs=(require_gl,),
    ),
    "ur": Setting(bringup=UR, instead=LOCAL, needs=(require_ur_rtde,)),
    "urscript": Setting(bringup=UR, instead=LOCAL),
}
"""Page → its setting; a page that is not here needs nothing."""


def python_blocks(page: Path) -> list[tuple[Block, Block | None]]:
    """Return the blocks of the page's program, each with what it prints, if told."""
    found = blocks(page)
    after = [*found, None][1:]
    return [
        (block, told if told is not None and told.is_output else None)
        for block, told in zip(found, after, strict=True)
        if block.language == "python" and not block.title
    ]


ENGLISH = [
    page
    for page in sorted([*DOCS.glob("how-to/*.md"), *DOCS.glob("reference/*.md")])
    if not page.stem.endswith(".zh-CN")
]
PAGES = [page for page in ENGLISH if python_blocks(page)]


def save_files(page: Path, setting: Setting, folder: Path) -> None:
    for block in blocks(page):
        if block.title and block.language in ("python", "yaml", "xml"):
            (folder / block.title).write_text(block.text, encoding="utf-8")
    for name, text in setting.files.items():
        (folder / name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_blocks_run_and_print_what_the_page_says(
    page: Path, tmp_path: Path
) -> None:
    setting = SETTINGS.get(page.stem, Setting())
    for need in setting.needs:
        need()
    save_files(page, setting, tmp_path)
    found = python_blocks(page)
    run = [n for n in range(len(found)) if n not in setting.not_run]
    for n in setting.not_run:
        compile(found[n][0].text, page.name, "exec")
    program = [setting.before]
    for n in run:
        program += [f"print('<<<{n}>>>')", found[n][0].text]
    source = "\n".join(program)
    for said, instead in setting.instead.items():
        assert said in source
        source = source.replace(said, instead)
    host = free_host()
    (tmp_path / "page.py").write_text(source.replace(HOST, host), encoding="utf-8")
    runtime = tmp_path
    with ExitStack() as stack:
        if setting.bringup is not None:
            options = [host if word == HOST else word for word in setting.bringup]
            bringup = stack.enter_context(closing(Bringup(os.environ, *options)))
            bringup.wait()
            runtime = Path(bringup.runtime_folder)
        done = subprocess.run(
            [sys.executable, "page.py"],
            cwd=tmp_path,
            env={**os.environ, "XDG_RUNTIME_DIR": str(runtime)},
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


def test_every_setting_is_that_of_a_page() -> None:
    assert SETTINGS.keys() <= {page.stem for page in PAGES}
