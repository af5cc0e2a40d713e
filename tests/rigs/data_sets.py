"""What is in a folder of episodes, and programs that collect."""

from __future__ import annotations

import hashlib
import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fake_tasks import WALK

RIGS = Path(__file__).parent
POLICY = "fake_tasks:Homeward"


def content(folder: Path) -> dict[str, str]:
    """Return the digest of every file, by its name."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != ".lock"
    }


def rows(folder: Path) -> list[dict[str, Any]]:
    """Return the rows about whole episodes, and check that each has its file."""
    path = folder / "episodes.jsonl"
    text = path.read_text() if path.exists() else ""
    found = [
        json.loads(line) for line in text.splitlines(keepends=True) if line[-1:] == "\n"
    ]
    for index, row in enumerate(found):
        file = folder / f"data/chunk-000/episode_{index:06d}.parquet"
        assert row["episode_index"] == index
        assert hashlib.sha256(file.read_bytes()).hexdigest() == row["sha256"]
    return found


@contextmanager
def collecting(
    folder: Path, n_episodes: int, *options: str, pace: float = 0.2
) -> Iterator[subprocess.Popen[str]]:
    """Start the command, slowly enough to be interrupted."""
    command = [sys.executable, "-m", "tool0", "collect", "--task", WALK]
    command += ["--episodes", str(n_episodes), "--folder", str(folder)]
    variables = {"PYTHONPATH": str(RIGS), "TOOL0_TEST_PACE": str(pace)}
    with subprocess.Popen(
        [*command, "--policy", POLICY, *options],
        env=os.environ | variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def wait_for_rows(process: subprocess.Popen[str], folder: Path, n: int) -> None:
    """Wait until there are ``n`` episodes; the process has to go on."""
    descriptor = os.pidfd_open(process.pid)
    try:
        while len(rows(folder)) < n:
            ended, _, _ = select.select([descriptor], [], [], 0.02)
            assert not ended, process.communicate()
    finally:
        os.close(descriptor)


def kill_one(title: str) -> None:
    """Kill a process whose command line has ``title``, among all that we started."""
    from processes import descendants

    for pid in descendants(os.getpid()):
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        if any(word.decode().startswith(title) for word in words):
            os.kill(pid, signal.SIGKILL)
            return
    raise AssertionError(title)
