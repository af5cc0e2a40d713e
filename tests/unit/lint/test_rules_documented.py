"""docs/how-to/check.md names the rules that there are."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tool0.control.ros1.lint import OF_TOOL0

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
COMPOSED = {"duplicate-link", "duplicate-joint"}
OF_SCENES = {"far-object"}
"""Warnings of a bring-up: `tool0 check` reads no scenes."""
SOURCES = ("lint", "control", "description")
MAKERS = ("finding", "report", "error_at", "warning_at", "error", "warning", "_problem")


def raised(tree: ast.AST) -> Iterator[str]:
    """Yield the rules that the calls in a module name."""
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        name = getattr(call.func, "attr", None) or getattr(call.func, "id", "")
        values = [item.value for item in call.keywords if item.arg == "rule"]
        for value in (*values, *(call.args[:2] if name in MAKERS else ())):
            text = getattr(value, "value", None)
            if isinstance(text, str) and re.fullmatch(r"[a-z]+(-[a-z0-9]+)+", text):
                yield text


def test_every_rule_in_the_document_is_in_the_code_and_back() -> None:
    code = "\n".join(
        file.read_text(encoding="utf-8")
        for folder in SOURCES
        for file in (ROOT / "src" / "tool0" / folder).rglob("*.py")
    )
    table = (ROOT / "docs/how-to/check.md").read_text(encoding="utf-8")
    rows = [row for row in table.splitlines() if row.startswith("| ")]
    names = r"`([a-z]+(?:-[a-z0-9]+)*)`"
    documented = {rule for row in rows for rule in re.findall(names, row)}
    assert set(raised(ast.parse(code))) - documented - set(OF_TOOL0) == OF_SCENES
    assert {rule for rule in documented if f'"{rule}"' not in code} == COMPOSED
