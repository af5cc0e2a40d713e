"""``tool0 view``: a robot without physics in a web page, posed by sliders."""

from __future__ import annotations

import contextlib
import sys

from tool0.cli.options import READERS, PanelOptions
from tool0.cli.panel import listening, show
from tool0.cli.parsing import parse
from tool0.cli.stop_signal import StopSignal
from tool0.cli.text import panel_line
from tool0.description.config import DescriptionConfig
from tool0.runtime.config import SimulationConfig


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    parse(view, command, arguments, readers=READERS, flag_pairs=True)
    return 0


def view(
    description: DescriptionConfig = DescriptionConfig(),  # noqa: B008  # frozen
    spawn_z: float = SimulationConfig().spawn_z,  # frozen
    panel: PanelOptions = PanelOptions(),  # noqa: B008  # frozen
) -> None:
    """Show a robot in a web page, without physics, and pose its joints there.

    Args:
        description: Which robot.
        spawn_z: Height of the robot's root above the ground [m].
        panel: Where the page is.
    """
    from tool0.description.catalogue import load_description
    from tool0.interfaces.panel.server import Panel
    from tool0.interfaces.panel.view import RobotView

    with contextlib.ExitStack() as exits:
        endpoint = exits.enter_context(listening(panel))
        stop = exits.enter_context(StopSignal())
        robot = RobotView(load_description(description), ground=-spawn_z)
        exits.enter_context(Panel(robot, endpoint=endpoint))
        print(f"{panel_line(endpoint.url)}\nCtrl-C ends it.", flush=True)
        show(endpoint.url, panel, sys.stdout)
        stop.wait()
