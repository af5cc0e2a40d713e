"""The process that a probe runs in: what it finds is printed as JSON.

It ends with whoever started it, and at its deadline whatever it does: standard input
is a pipe that only they hold open.
"""

from __future__ import annotations

import faulthandler
import json
import os
import signal
import sys
import threading


def main(module: str, function: str, patience: float) -> None:
    """Run ``function`` of ``module``, which returns lines, and print those.

    Args:
        module: Its name.
        function: Its name.
        patience: Wall seconds after which this process ends.
    """
    faulthandler.dump_traceback_later(patience, exit=True)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    answer = os.dup(1)
    os.dup2(2, 1)  # whatever a library prints is no answer
    from importlib import import_module

    from tool0.installation.doctor.dependencies import without
    from tool0.installation.doctor.machine import Machine

    try:
        lines = getattr(import_module(module), function)(Machine())
    except ImportError as error:
        lines = [without(function.replace("_", "-"), error)]
    with os.fdopen(answer, "w", encoding="utf-8") as stream:
        json.dump([line.as_json() for line in lines], stream)
    sys.stderr.flush()
    os._exit(0)  # a library's thread or exit handler may not hold us


def _end_with_parent() -> None:
    os.read(0, 1)  # nobody writes: it returns at the end
    if sys.platform == "win32":
        os._exit(1)
    os.killpg(0, signal.SIGKILL)  # and with us what we started
