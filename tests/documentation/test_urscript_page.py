"""What docs/how-to/urscript.md says of errors, of the interpreter, and of torques."""

from __future__ import annotations

import os
import socket
from contextlib import closing
from pathlib import Path

import pytest
from document import blocks
from ros import Bringup
from ur_address import free_host

from tool0.ur.urscript.program import compile_program
from tool0.ur.urscript.errors import ScriptError

PAGE = Path(__file__).parents[2] / "docs/how-to/urscript.md"
TEXTS = {block.title: block.text for block in blocks(PAGE)}
WRONG = """def pick():
  home = get_actual_joint_positions()
  movej(home)
  movej([0, 1, 2])

  # the name is misspelt
  movje(home)
"""
