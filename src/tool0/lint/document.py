"""A text that tells how to set a robot up: what it shows, and where it points."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from tool0.description.finding import Finding
from tool0.errors import SourceLocation
from tool0.lint.launch_file import read as read_launch_file
from tool0.lint.parameters.file import YamlText, yaml_findings
from tool0.lint.robot_file import read_xacro_source
from tool0.lint.snippets import Snippet, snippets
from tool0.lint.upstream import UPSTREAM, edit_findings, known_findings

_FILE = re.compile(
    r"([\w.-]+\.(?:launch\.xml|launch|urdf\.xacro|xacro|ya?ml|urdf))\b", re.ASCII
)
_PATH = re.compile(r"^\s*`?([\w~.$-]*/[\w~./-]*\.\w+)`?\s*$")
_HERE_IT_IS = re.compile(
    r"路径|\bpath\b|\blocated\b|\bfound (?:at|in)\b", re.IGNORECASE
)
_CHANGES = re.compile(
    r"打开|修改|编辑|复制|注释|删除|\b(?:open|edit|change|modify|copy|paste|delete)\b",
    re.IGNORECASE,
)
_NEAR = 3
"""[lines] with something on them, between what is announced and its path."""
_NEEDS_THE_REST = frozenset(
    {
        *("missing-file", "missing-argument", "unused-argument", "missing-include"),
        *("unresolved-uri", "unresolved-find", "unknown-package"),
    }
)
"""Rules that a snippet cannot break: what they look for stands elsewhere."""


def document_findings(file: Path) -> Iterator[Finding]:
    """Yield what is wrong in a text: in its snippets, and in what it says of files."""
    text = file.read_text(encoding="utf-8", errors="replace")
    lines = text.splitlines()
    yield from _paths(file, lines)
    yield from known_findings(text, SourceLocation(file, 1), lambda _: False)
    for snippet in snippets(text):
        location = SourceLocation(file, snippet.row + 1)
        if snippet.kind == "yaml":
            yaml = YamlText(snippet.text, location)
            if yaml.is_about_controllers:
                yield from yaml_findings([yaml])
        else:
            yield from _xml_findings(file, snippet)


def _xml_findings(file: Path, snippet: Snippet) -> Iterator[Finding]:
    """Yield what is wrong in XML that is a whole launch file or robot."""
    is_launch = "</launch>" in snippet.text
    if not is_launch and "</robot>" not in snippet.text:
        return
    with tempfile.TemporaryDirectory(prefix="tool0-check-") as folder:
        name = "snippet.launch" if is_launch else "snippet.xacro"
        copy = Path(folder, name)
        # A comment pads it, so that its lines have the numbers that they have there.
        before = "<!--" + "\n" * snippet.row + "-->" if snippet.row else ""
        body = re.sub(r"^\s*<\?xml[^>]*\?>", "", snippet.text)
        copy.write_text(before + body, encoding="utf-8")
        if is_launch:
            found: Sequence[Finding] = read_launch_file(copy, {}).findings
        else:
            found = read_xacro_source(copy, {}).findings
        for finding in found:
            if finding.rule in _NEEDS_THE_REST:
                continue
            if finding.location.file == copy:
                line = finding.location.line
                yield replace(finding, location=SourceLocation(file, line))
            else:
                yield finding
    for finding in edit_findings(file, snippet.text, None):
        line = (finding.location.line or 1) + snippet.row
        yield replace(finding, location=SourceLocation(file, line))


def _paths(file: Path, lines: Sequence[str]) -> Iterator[Finding]:
    """Yield paths that are not those of the file announced, or are not one's own."""
    written = [(row, line) for row, line in enumerate(lines) if line.strip()]
    for place, (row, line) in enumerate(written):
        match = _PATH.match(line)
        if match is None:
            continue
        path = Path(match[1])
        for _, before in reversed(written[max(0, place - _NEAR) : place]):
            names = list(dict.fromkeys(_FILE.findall(before)))
            is_announced = _HERE_IT_IS.search(before) is not None
            if is_announced and _CHANGES.search(before):
                yield from _told_to_change(file, row, path)
            if is_announced:
                if len(names) == 1 and names[0] != path.name:
                    yield Finding(
                        location=SourceLocation(file, row + 1),
                        rule="wrong-path",
                        key=names[0],
                        message=f"the text is about '{names[0]}', but the path is that "
                        f"of '{path.name}'",
                        remedy=f"give the path of '{names[0]}'",
                    )
                break


def _told_to_change(file: Path, row: int, path: Path) -> Iterator[Finding]:
    package = next((part for part in reversed(path.parts) if part in UPSTREAM), None)
    if package is not None:
        yield Finding(
            location=SourceLocation(file, row + 1),
            rule="edited-upstream",
            severity="warning",
            key=path.name,
            message=f"the text changes a file of '{package}' in place: the next "
            "update, or the next person's clone, is without it",
            remedy="put it into a file of your own that includes this one; "
            "`tool0 workspace` does",
        )
