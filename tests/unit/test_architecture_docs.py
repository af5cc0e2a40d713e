"""The pages on the code name files and packages that exist."""

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ROOT / "src" / "tool0"
PAGES = [ROOT / "docs" / "architecture.md", *sorted(PACKAGES.rglob("README.md"))]
PATH = re.compile(r"`([\w.-]+(?:/[\w.-]+)*)/?`")
"""What may be a path, such as `control/dialect.py` or `motion/planner`."""


@cache
def known() -> str:
    """Return the paths of all files and folders, one a line, with and without .py."""
    names = ("benchmarks", "docs", "src/tool0", "tests", "tools", "web/src")
    paths = [path for name in names for path in (ROOT / name).rglob("*")]
    paths.extend(ROOT.glob("*.py"))
    lines = [f"/{path.relative_to(ROOT)}" for path in paths]
    return "\n".join([*lines, *(line.removesuffix(".py") for line in lines), ""])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.parent.name)
def test_every_file_that_a_page_names_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    named = [
        path
        for path in PATH.findall(text)
        if "/" in path or path.endswith((".py", ".ts", ".cc", ".c", ".h"))
    ]
    assert [path for path in named if f"/{path}\n" not in known()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.parent.name)
def test_every_link_of_a_page_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []
