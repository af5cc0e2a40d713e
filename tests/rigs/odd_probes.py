"""Probes of ``tool0 doctor`` that fail, hang or leave a process behind."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import Machine

OddProbe = Callable[[Machine], list[ProbeResult]]


def fine(_: Machine) -> list[ProbeResult]:
    print("what a library prints is not part of the answer")
    sys.stdout.flush()
    os.write(1, b"nor is this")
    return [ProbeResult("fine", "ready", "\N{SNOWMAN}")]


def raises(_: Machine) -> list[ProbeResult]:
    raise RuntimeError("no such thing")


def crashes(_: Machine) -> list[ProbeResult]:
    os.kill(os.getpid(), signal.SIGSEGV)
    return []


def leaves(_: Machine) -> list[ProbeResult]:
    os._exit(7)


def hangs(_: Machine) -> list[ProbeResult]:
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    other = subprocess.Popen(["sleep", "1000"])
    _pids().write_text(f"{os.getpid()} {other.pid}\n")
    time.sleep(1000)
    return []


def leaves_one_behind(_: Machine) -> list[ProbeResult]:
    other = subprocess.Popen(["sleep", "1000"])  # it holds our output open
    _pids().write_text(f"{other.pid}\n")
    return [ProbeResult("left", "ready", "")]


def _pids() -> Path:
    """Return where the test reads whom a probe started."""
    return Path(os.environ["PIDS"])
