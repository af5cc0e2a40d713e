"""docs/check.md names the rules that there are."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from tool0.control.lint import OF_TOOL0

ROOT = Path(__file__).parents[3]
COMPOSED = {"duplicate-link", "duplicate-joint"}
SOURCES = ("lint", "control", "description")
PLACE_OF_RULE = {
    **{"finding": 0, "report": 1, "error_at": 1, "warning_at": 1, "_finding": 1},
    **{"_problem": 0, "_refused": 1},
}
"""Position of the rule among the arguments of what makes findings."""


def raised(tree: ast.AST) -> Iterator[str]:
    """Yield the rules that the calls in a module name."""
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call):
            continue
        function = call.func
        name = getattr(function, "attr", None) or getattr(function, "id", "")
        rules = [item.value for item in call.keywords if item.arg == "rule"]
        if name in PLACE_OF_RULE and len(call.args) > PLACE_OF_RULE[name]:
            rules.append(call.args[PLACE_OF_RULE[name]])
        for rule in rules:
            for node in ast.walk(rule):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    yield node.value


def test_every_rule_in_the_document_is_in_the_code_and_back() -> None:
    code = "\n".join(
        file.read_text(encoding="utf-8")
        for folder in SOURCES
        for file in (ROOT / "src" / "tool0" / folder).rglob("*.py")
    )
    table = (ROOT / "docs" / "check.md").read_text(encoding="utf-8")
    rows = [row for row in table.splitlines() if row.startswith("| ")]
    names = r"`([a-z]+(?:-[a-z0-9]+)*)`"
    documented = {rule for row in rows for rule in re.findall(names, row)}
    rules = {
        r for r in raised(ast.parse(code)) if re.fullmatch(r"[a-z]+(-[a-z0-9]+)+", r)
    }
    assert rules - documented - set(OF_TOOL0) == set()
    assert {rule for rule in documented if f'"{rule}"' not in code} == COMPOSED
