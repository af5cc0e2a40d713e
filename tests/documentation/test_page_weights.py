"""A page with its pictures is small enough for a slow connection."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("README*.md"), *(ROOT / "docs").rglob("*.md")]
MOST = 500_000  # [bytes]
MARKUP = 2
"""HTML has about as many times the bytes of Markdown."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_with_its_pictures_is_small(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    pictures = set(re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text))
    sizes = [(page.parent / picture).stat().st_size for picture in pictures]
    assert MARKUP * len(text.encode()) + sum(sizes) <= MOST
