"""Every example runs as it stands, without a display and without a warning."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from promised import require_gl
from ros import free_port

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.py"))
_LATE = re.compile(r"\d+ ticks began late in the last second")
"""What an example in real time says on a busy machine."""


def run(example: Path, folder: Path) -> str:
    """Run it elsewhere, with warnings as errors, and return what it printed."""
    environment = {k: v for k, v in os.environ.items() if k != "DISPLAY"}
    warnings = ["-W", "error"]
    if example.stem.endswith("_ros1"):
        environment["ROS_MASTER_URI"] = f"http://127.0.0.1:{free_port()}"
        environment["ROS_HOME"] = environment["ROS_LOG_DIR"] = str(folder.parent)
        warnings = []  # rospy has its own
    done = subprocess.run(
        [sys.executable, *warnings, str(example)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    said = [line for line in done.stderr.splitlines() if not _LATE.fullmatch(line)]
    assert said == []
    return done.stdout


def test_they_are_numbered_without_a_gap() -> None:
    numbers = [int(path.name.partition("_")[0]) for path in EXAMPLES]
    assert numbers == list(range(1, len(EXAMPLES) + 1))
    assert len(EXAMPLES) >= 6


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_is_short(example: Path, tmp_path: Path) -> None:
    if example.stem.endswith("_camera"):
        require_gl()
    text = example.read_text()
    assert len(text.splitlines()) < 60
    ast.parse(text, feature_version=(3, 10))
    assert run(example, tmp_path).strip()
    assert not list(tmp_path.iterdir())  # it leaves nothing behind


def test_the_first_one_succeeds_as_the_readme_says(tmp_path: Path) -> None:
    lines = run(EXAMPLES[0], tmp_path).splitlines()
    assert lines[0] == "GoalResult(status=SUCCEEDED, error_code=0, error_string='')"
    time, elbow, pose = lines[1].split(maxsplit=2)
    assert 3.0 <= float(time) <= 3.7
    assert float(elbow) == pytest.approx(1.4, abs=0.02)
    assert pose.startswith("Transform(position=(")


def test_the_python_in_the_readme_runs_too(tmp_path: Path) -> None:
    readme = (EXAMPLES[0].parent.parent / "README.md").read_text()
    blocks = [part.partition("```")[0] for part in readme.split("```python\n")[1:]]
    assert blocks
    for number, block in enumerate(blocks):
        path = tmp_path / f"{number}.py"
        path.write_text(block)
        assert "SUCCEEDED" in run(path, tmp_path)
