"""The messages that docs/how-to/troubleshooting.md explains are tool0's own."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import tool0
from tool0.description.loading import assemble

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/how-to/troubleshooting.md"
HOLE = "\0"
"""Stands for a value in a message of the source."""


RAISED: dict[str, Callable[[tool0.Robot], object]] = {
    "unknown arm '…'": lambda _: assemble("ur6"),
    "moves joint '…' to …, which is beyond its limits": (
        lambda robot: robot.move_joints({"elbow_joint": 9.0})
    ),
    "no running JointTrajectoryController drives '…'": (
        lambda robot: robot.move_joints({"elbo_joint": 1.0})
    ),
    "out of reach: the centre of the wrist": (
        lambda robot: robot.arm.move_to(tool0.Pose(xyz=(2.0, 0.0, 0.4)))
    ),
}
"""Messages that are put together from several texts → what raises them."""


def messages(page: Path = PAGE) -> list[str]:
    text = page.read_text(encoding="utf-8")
    return re.findall(r"^\| `([^`]+)` \| ", text, re.MULTILINE)


def literals() -> Iterator[str]:
    """Yield every text in the source, with holes for values."""
    for file in (ROOT / "src/tool0").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                yield "".join(
                    str(part.value) if isinstance(part, ast.Constant) else HOLE
                    for part in node.values
                )
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield re.sub(r"\{[^}]*\}", HOLE, node.value)
    yield (ROOT / "web/src/i18n/en.ts").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def source() -> str:
    return "\n".join(literals())


def pattern(message: str) -> str:
    parts = [part.strip() for part in message.split("…")]
    return r"[^\n]*".join(re.escape(part) for part in parts if part)


@pytest.mark.parametrize("message", sorted({*messages()} - RAISED.keys()))
def test_tool0_has_the_message(message: str, source: str) -> None:
    assert re.search(pattern(message), source), message


def test_the_others_are_raised() -> None:
    with tool0.bringup(realtime=False) as robot:
        for message in {*messages()} & RAISED.keys():
            with pytest.raises(tool0.Tool0Error, match=pattern(message)):
                RAISED[message](robot)


def test_every_message_says_what_to_do() -> None:
    rows = re.findall(r"^\| `[^`]+` \| (.+) \|$", PAGE.read_text("utf-8"), re.M)
    assert len(rows) == len(messages()) > 30


def test_both_languages_have_the_same_messages() -> None:
    assert messages(PAGE.with_suffix(".zh-CN.md")) == messages()
