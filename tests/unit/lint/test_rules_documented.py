"""docs/check.md names the rules that there are."""

import re
from pathlib import Path

from tool0.control.lint import OF_TOOL0

ROOT = Path(__file__).parents[3]
COMPOSED = {"duplicate-link", "duplicate-joint"}
SOURCES = ("lint", "control", "description")


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
    raised = set(re.findall(r'rule="([a-z0-9-]+)"', code))
    assert raised - documented - set(OF_TOOL0) == set()
    assert {rule for rule in documented if f'"{rule}"' not in code} == COMPOSED
