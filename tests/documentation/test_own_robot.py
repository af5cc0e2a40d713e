"""The commands of docs/how-to/own-robot.md copy an arm and a gripper, and load them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from document import blocks

from tool0.cli.options import READERS, BringupOptions
from tool0.cli.parsing import parse

PAGE = Path(__file__).parents[2] / "docs/how-to/own-robot.md"
SERVERS = ("bringup", "view")
"""Commands that do not end by themselves; their options are parsed."""


def test_the_commands_work_in_a_fresh_folder(tmp_path: Path) -> None:
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, words in {"python": "", "tool0": "-m tool0"}.items():
        program = programs / name
        program.write_text(f'#!/bin/sh\nexec "{sys.executable}" {words} "$@"\n')
        program.chmod(0o755)
    for block in (block for block in blocks(PAGE) if block.language == "sh"):
        script = ["set -e"]
        for line in block.commands():
            program, *words = line.split()
            if program == "tool0" and words[0] in SERVERS:
                parse(BringupOptions, words[0], words[1:], READERS)
            else:
                script.append(line)
        done = subprocess.run(
            ["bash", "-c", "\n".join(script)],
            cwd=tmp_path,
            env={**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "my_arm/default_kinematics.yaml").is_file()
    assert (tmp_path / "my_gripper/macro.xacro").is_file()
