"""The process of the UR interface, where something is missing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tool0.server.companion import UNABLE

pytestmark = pytest.mark.slow  # it starts a program


def test_without_the_parser_it_ends_in_one_line_before_it_connects(
    tmp_path: Path,
) -> None:
    (tmp_path / "lark.py").write_text("raise ImportError('no lark here')\n")
    path = os.pathsep.join(
        [str(tmp_path), *os.environ.get("PYTHONPATH", "").split(":")]
    )
    done = subprocess.run(
        [sys.executable, "-m", "tool0.ur", "--name", "nobody"],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == UNABLE
    assert (done.stdout, done.stderr) == ("", "tool0: error: no lark here\n")
