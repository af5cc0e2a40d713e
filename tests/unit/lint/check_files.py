"""Writing files and checking them, for tests."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from pathlib import Path

from tool0.description.finding import Finding
from tool0.errors import SourceLocation
from tool0.lint.check import check
from tool0.lint.parameters.yaml_text import YamlText, yaml_findings
from tool0.lint.robot.facts import RobotFacts

DATA = Path(__file__).parents[2] / "data"

Summary = list[tuple[int | None, str, str]]


def summary(findings: Iterable[Finding]) -> Summary:
    """Return line, rule and key of each finding."""
    return [(item.location.line, item.rule, item.key) for item in findings]


def of_yaml(text: str, robot: RobotFacts | None = None) -> list[Finding]:
    """Return what is wrong in a YAML."""
    yaml = YamlText(textwrap.dedent(text), SourceLocation(Path("c.yaml"), 1))
    return list(yaml_findings([yaml], robot))


def write(folder: Path, files: dict[str, str]) -> Path:
    """Write files by their paths below ``folder``, and return it."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text).lstrip("\n"), encoding="utf-8")
    return folder


def rules(folder: Path, *names: str) -> list[tuple[str, int | None, str]]:
    """Return file, line and rule of each finding in files below ``folder``."""
    paths = [folder / name for name in names] if names else [folder]
    return [
        (
            str((item.location.file or folder).resolve().relative_to(folder.resolve())),
            item.location.line,
            item.rule,
        )
        for item in check(paths).findings
    ]
