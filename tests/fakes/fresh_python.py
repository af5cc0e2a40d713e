"""Programs in a Python of their own: what is imported here stays imported."""

from __future__ import annotations

import os
import subprocess
import sys


def start(program: str, *arguments: str, **variables: str) -> subprocess.Popen[str]:
    """Start a program, in which warnings are errors too."""
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", program, *arguments],
        env=os.environ | variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(program: str, *arguments: str, **variables: str) -> str:
    """Return what it prints; it has to succeed."""
    with start(program, *arguments, **variables) as process:
        out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    return out
