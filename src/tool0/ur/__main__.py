"""``python -m tool0.ur``: the UR interface for a running bring-up."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import gc
import json
import logging
import signal
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Final

from tool0.errors import Tool0Error
from tool0.installation import garbage
from tool0.server.companion import UNABLE
from tool0.ur.compiling import prepare
from tool0.ur.options import UrArm, UrOptions
from tool0.ur.service import connected, serve

_FORMAT = "[%(levelname)s] [%(created).3f] [%(name)s]: %(message)s"
"""Format of log messages, which is the same as ROS's. The bring-up parses the
messages."""
SWITCH_INTERVAL: Final = 0.0005
"""Longest time for which a thread that plans or compiles delays the event loop [s]: a
quarter of RTDE's period."""


def main() -> int:
    """Present a bring-up as a UR until it ends or Ctrl-C is pressed."""
    arguments = _arguments()
    logging.addLevelName(logging.WARNING, "WARN")
    logging.basicConfig(level=logging.INFO, format=_FORMAT, stream=sys.stderr)
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        options = UrOptions(
            host=arguments.host,
            port_base=arguments.port_base,
            programs=arguments.programs,
            allow_sockets=arguments.allow_sockets,
            active_gripper=arguments.active_gripper,
        )
        asyncio.run(_run(arguments.name, options))
    except ImportError as error:  # the installation is damaged
        print(f"tool0: error: {error}", file=sys.stderr)
        return UNABLE
    except Tool0Error as error:
        print(f"tool0: error: {error}", file=sys.stderr)
        return 1
    return 0


async def _run(name: str, options: UrOptions) -> None:
    task = asyncio.current_task()
    assert task is not None
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, task.cancel)
    with contextlib.suppress(asyncio.CancelledError):
        await asyncio.to_thread(prepare)  # the bring-up may still be starting
        channel = await connected(name)
        try:
            await serve(channel, options, _report)
        finally:
            channel.close()


def _report(arms: Mapping[str, UrArm]) -> None:
    """Report to the parent process that the ports are open."""
    gc.collect()
    garbage.started()
    rows = {name: asdict(arm) for name, arm in arms.items()}
    print(json.dumps({"ready": True, "arms": rows}), flush=True)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog=f"python -m {__package__}",
        description="Present a robot that tool0 simulates as a UR's control box.",
    )
    add = parser.add_argument
    add("--name", default="tool0", help="the --name of the bring-up")
    add("--host", default="127.0.0.1", help="address of the first arm")
    add("--port-base", type=int, default=0, help="added to the numbers of the ports")
    add("--programs", type=Path, help="folder with programs for the dashboard server")
    add("--allow-sockets", action="store_true", help="connect to other machines")
    add("--active-gripper", action="store_true", help="start with it activated")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
