"""The pages as a whole: their blocks, their languages, their links, and the index."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from document import Block, blocks

from tool0.description.cell_file import load_cell
from tool0.description.scene_file import load_scene
from tool0.description.yaml_tree import read_mapping
from tool0.programs.files import read_program

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
FOLDERS = ("tutorials", "how-to", "reference", "explanation")
PAGES = [page for folder in FOLDERS for page in sorted((DOCS / folder).glob("*.md"))]
CHINESE = [page for page in PAGES if page.stem.endswith(".zh-CN")]
ENGLISH = [page for page in PAGES if page not in CHINESE]
READMES = (ROOT / "README.md", ROOT / "README.zh-CN.md")
LANGUAGES = {"sh", "python", "yaml", "xml", "json", "text", "cpp"}
TITLES_OF_TEXT = {
    "": "what the block before it prints",
    "example": "the same, with other numbers",
    "errors": "messages",
    "tree": "files",
    "diagram": "a picture",
    "interpreter": "a dialogue on a port of URScript",
    "program": "a program of URScript",
}


def english_of(page: Path) -> Path:
    return page.with_name(page.name.replace(".zh-CN", ""))


# ---- blocks --------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_block_says_what_it_is(page: Path) -> None:
    for block in blocks(page):
        if not block.language.startswith("{"):
            assert block.language in LANGUAGES, block
        if block.language == "text":
            assert block.title in TITLES_OF_TEXT, block


READERS = {
    "cell": load_cell,
    "my_scene": load_scene,
    "scene": load_scene,
    "pick": read_program,
}
"""Files of the guides → what reads them; those of the reference have their own test."""


@pytest.mark.parametrize("page", ENGLISH, ids=lambda page: page.name)
def test_files_are_read_by_what_they_are_for(page: Path, tmp_path: Path) -> None:
    """YAML of the guides; the other folders have tests of their own."""
    for block in (block for block in blocks(page) if block.language == "yaml"):
        file = tmp_path / (block.title or "block.yaml")
        file.write_text(block.text, encoding="utf-8")
        reader = READERS.get(file.stem)
        if page.parent.name == "how-to":
            if reader is not None:
                reader(file)
            elif block.title:
                read_mapping(file)
            else:  # a step of the program before it
                program = next(b for b in blocks(page) if b.title == "pick.yaml")
                file.write_text(program.text + block.text, encoding="utf-8")
                read_program(file)


# ---- languages -----------------------------------------------------------------------


def without_comments(block: Block) -> object:
    if block.language in ("", "sh"):
        return [shlex.split(line, comments=True) for line in block.commands()]
    if block.language in ("yaml", "python", "cpp"):
        return re.sub(r"(^|  )(#|//).*$", "", block.text, flags=re.MULTILINE)
    if block.title == "diagram" or block.language.startswith("{"):
        return None  # its words are translated
    return block.text


def test_tutorials_and_guides_have_both_languages() -> None:
    pages = {*DOCS.glob("tutorials/*.md"), *DOCS.glob("how-to/*.md")}
    assert {english_of(page) for page in pages} == pages - {*CHINESE}
    assert all(page.with_suffix(".zh-CN.md") in pages for page in pages - {*CHINESE})


@pytest.mark.parametrize("page", [*CHINESE, READMES[1]], ids=lambda page: page.name)
def test_both_languages_have_the_same_blocks(page: Path) -> None:
    ours, theirs = blocks(english_of(page)), blocks(page)
    assert [(b.language, b.title) for b in ours] == [
        (b.language, b.title) for b in theirs
    ]
    for one, other in zip(ours, theirs, strict=True):
        assert without_comments(one) == without_comments(other)


@pytest.mark.parametrize("page", CHINESE, ids=lambda page: page.name)
def test_each_language_links_to_the_other(page: Path) -> None:
    english = english_of(page)
    assert page.read_text("utf-8").splitlines()[2] == f"[English]({english.name})"
    assert english.read_text("utf-8").splitlines()[2] == f"[中文]({page.name})"


# ---- the index -----------------------------------------------------------------------


def test_the_index_describes_every_page() -> None:
    text = (DOCS / "index.md").read_text("utf-8")
    described, _, _ = text.partition("```{toctree}")
    linked = re.findall(r"\]\(([^)#]+)\)", described)
    for page in ENGLISH:
        assert page.relative_to(DOCS).as_posix() in linked


def test_the_chinese_index_lists_every_chinese_page() -> None:
    text = (DOCS / "index.zh-CN.md").read_text("utf-8")
    for page in CHINESE:
        name = page.relative_to(DOCS).as_posix().removesuffix(".md")
        assert re.search(rf"^{re.escape(name)}$|\({re.escape(name)}\.md\)", text, re.M)


# ---- links ---------------------------------------------------------------------------


def all_documents() -> list[Path]:
    top = [*ROOT.glob("*.md"), *DOCS.rglob("*.md")]
    below = [
        page
        for folder in ("src", "tests", "plugins", "benchmarks", "examples", "web")
        for page in (ROOT / folder).rglob("*.md")
        if not {"node_modules", "static"} & {*page.relative_to(ROOT).parts}
    ]
    return sorted([*top, *below])


def anchor(heading: str) -> str:
    """Return what GitHub calls a heading."""
    shown = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")


def anchors(page: Path) -> set[str]:
    """Return those of a page; a heading that occurs again has a number."""
    text = re.sub(r"^( *)```.*?^\1```$", "", page.read_text("utf-8"), flags=re.S | re.M)
    found: dict[str, int] = {}
    for heading in re.findall(r"^#+ (.+)$", text, re.M):
        name = anchor(heading.strip())
        found[name] = found.get(name, -1) + 1
        if found[name]:
            found[f"{name}-{found[name]}"] = 0
    return {*found, *re.findall(r'<a (?:id|name)="([^"]+)"', text)}


@pytest.mark.parametrize(
    "page", all_documents(), ids=lambda page: page.relative_to(ROOT).as_posix()
)
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"^( *)```.*?^\1```$", "", page.read_text("utf-8"), flags=re.S | re.M)
    text = re.sub(r"`[^`\n]*`", "", text)
    for target in re.findall(r"\]\(([^)\s]+)(?: \"[^\"]*\")?\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, section = target.partition("#")
        to = page.parent / file if file else page
        assert to.exists(), target
        if section and to.suffix == ".md":
            assert section in anchors(to), target
