"""Programs in a Python of their own: what is imported here stays imported."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def start(
    program: str, *arguments: str, **variables: str
) -> Iterator[subprocess.Popen[str]]:
    """Run a program, in which warnings are errors too; in the end it is ended."""
    with subprocess.Popen(
        [sys.executable, "-W", "error", "-c", program, *arguments],
        env=os.environ | variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def run(program: str, *arguments: str, **variables: str) -> str:
    """Return what it prints; it has to succeed."""
    with start(program, *arguments, **variables) as process:
        out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    return out
