"""Every type is the one that others know by that name: they agree on its md5 sum."""

import json
from pathlib import Path
from typing import Any

import pytest
from fresh_python import run
from promised import require_ros

from tool0.installation.ros1.messages import definition_files

MD5_SUMS = Path(__file__).parents[3] / "data" / "ros1" / "md5sums.txt"
OURS = ("control_msgs", "controller_manager_msgs", "gazebo_msgs")
OF_ACTIONS = (
    *("Action", "Goal", "Result", "Feedback"),
    *("ActionGoal", "ActionResult", "ActionFeedback"),
)
IMPORT = (
    "from tool0.installation.ros1.messages import import_messages; import_messages()\n"
)
SUMS = """
import importlib, json, sys
sums = {}
for name in json.loads(sys.argv[1]):
    package, _, kind = name.partition("/")
    for module in ("msg", "srv"):
        try:
            found = importlib.import_module(f"{package}.{module}")
        except ImportError:
            continue
        if hasattr(found, kind):
            sums[name] = getattr(found, kind)._md5sum
print(json.dumps(sums))
"""


def pinned() -> dict[str, str]:
    rows = MD5_SUMS.read_text(encoding="utf-8").splitlines()
    split = [row.split() for row in rows if not row.startswith("#")]
    return {name: md5 for name, md5, *_ in split}


def defined() -> set[str]:
    names = set()
    for package in OURS:
        for file in definition_files(package):
            kinds = OF_ACTIONS if file.suffix == ".action" else ("",)
            names |= {f"{package}/{file.stem}{kind}" for kind in kinds}
    return names


def test_every_type_has_the_md5_sum_that_others_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    require_ros()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    wanted = pinned()
    found: dict[str, Any] = json.loads(run(IMPORT + SUMS, json.dumps(list(wanted))))
    assert found == wanted


def test_no_type_of_ours_is_left_unpinned() -> None:
    assert defined() == {name for name in pinned() if name.split("/")[0] in OURS}
