"""Every type is the one that others know by that name: they agree on its hash."""

import json
from pathlib import Path

import pytest
from promised import require_ros2

from tool0.installation.ros2.install import DEFINITIONS, expected_prefix

HASHES = Path(__file__).parents[3] / "data" / "ros2" / "type_hashes.txt"


def pinned() -> dict[str, str]:
    rows = HASHES.read_text(encoding="utf-8").splitlines()
    return dict(row.split() for row in rows if not row.startswith("#"))


def test_the_hash_of_every_definition_is_pinned() -> None:
    files = (file.relative_to(DEFINITIONS) for file in DEFINITIONS.glob("*/*/*"))
    assert sorted(file.with_suffix("").as_posix() for file in files) == sorted(pinned())


def test_definitions_have_nothing_but_names_and_types() -> None:
    for file in DEFINITIONS.glob("*/*/*"):
        text = file.read_text(encoding="ascii")
        assert "#" not in text, file
        assert text.endswith("\n"), file


def test_the_hashes_are_those_of_the_original_types() -> None:
    ros2 = require_ros2()
    if ros2.kind != "own":
        pytest.skip(f"ROS 2 is {ros2.origin}, which has packages of its own")
    assert ros2.prefix.name == expected_prefix().name, "stale; run tool0 ros2 install"
    hashes = {}
    for name in pinned():
        file = ros2.prefix / "share" / f"{name}.json"
        described = json.loads(file.read_text(encoding="utf-8"))["type_hashes"]
        hashes[name] = {one["type_name"]: one["hash_string"] for one in described}[name]
    assert hashes == pinned()
