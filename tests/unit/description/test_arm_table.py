"""docs/reference/robots.md lists the ratings of every built-in arm."""

from __future__ import annotations

from pathlib import Path

import pytest

from tool0.description.catalogue import arms, find_part

PAGE = Path(__file__).parents[3] / "docs/reference/robots.md"


@pytest.mark.parametrize("name", arms())
def test_the_page_has_the_ratings_and_sources_of_the_folder(name: str) -> None:
    facts = find_part("arm", name).load("specifications")
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in PAGE.read_text(encoding="utf-8").splitlines()
        if line.startswith(f"| `{name}` |")
    ]
    ((_, payload, reach, source, unsourced),) = rows
    assert (float(payload), float(reach)) == (facts["payload"], facts["reach"])
    assert source.startswith("none ") == (facts["dh_source"] is None)
    for value, reason in facts["unsourced"].items():
        is_own = f"`{value}`: {reason}" in unsourced
        assert is_own or value in COMMON, f"the row of {name} lacks {value}"


COMMON = {
    "payload",
    "reach",
    "physical_parameters.base_mass",
    "physical_parameters.links.base",
    "joint_limits.elbow_joint",
    "appearance",
}
"""The page names these for all arms below the table."""
