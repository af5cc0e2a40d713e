"""``tool0 view``: a robot without physics in a web page, to be posed by sliders."""

from __future__ import annotations

import contextlib
import sys

from tool0.cli.bringup_text import panel_line
from tool0.cli.describe import described
from tool0.cli.options import DEFAULT_SPAWN_Z, PanelOptions, RobotOptions
from tool0.cli.panel import door_of, served, show
from tool0.cli.parsing import parse
from tool0.cli.stop_signal import StopSignal

_GLANCE = 10.0
"""Longest time between looks at the signals [wall s]; a signal wakes at once."""


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    parse(view, command, arguments, flag_pairs=True)
    return 0


def view(
    description: RobotOptions = RobotOptions(),  # noqa: B008  # frozen
    panel: PanelOptions = PanelOptions(),  # noqa: B008  # frozen
) -> None:
    """Show a robot in a web page, without physics, and pose its joints there.

    Args:
        description: Which robot.
        panel: Where the page is.
    """
    from tool0.interfaces.panel.source import ViewSource

    with contextlib.ExitStack() as exits:
        door = door_of(panel)
        exits.callback(door.listener.close)
        stop = exits.enter_context(StopSignal())
        spawn_z = description.spawn_z
        source = ViewSource(
            described(description),
            ground=-(DEFAULT_SPAWN_Z if spawn_z is None else spawn_z),
        )
        exits.enter_context(served(source, door))
        print(f"{panel_line(door.url)}\nCtrl-C ends it.", flush=True)
        show(door.url, panel, sys.stdout)
        while not stop.wait(_GLANCE):
            pass
