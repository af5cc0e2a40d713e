"""The panel of a command, and ``tool0 view``, which shows a robot without physics."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, TextIO

from tool0.cli import options
from tool0.cli.options import PanelOptions
from tool0.cli.stop_signal import StopSignal
from tool0.cli.text import panel_line
from tool0.description.config import DescriptionConfig
from tool0.description.units import Metres
from tool0.installation.machine import Machine
from tool0.simulation.config import SimulationConfig

if TYPE_CHECKING:
    from threading import Thread

    from tool0.panel.address import Endpoint

READERS = options.READERS


@contextlib.contextmanager
def listening(options: PanelOptions) -> Iterator[Endpoint]:
    """Listen on the address in the options; warn if other machines can connect."""
    from tool0.panel.address import open_endpoint
    from tool0.panel.server import is_page_built, load

    endpoint = open_endpoint(options.panel_host, options.panel_port)
    if endpoint.token is not None:
        print(
            f"tool0: warning: the panel listens at {endpoint.host}, port "
            f"{endpoint.port}; anyone with its address and token can drive the "
            "robot",
            file=sys.stderr,
        )
    if not is_page_built():
        print(
            "tool0: warning: the panel's page is not built; `make run` builds it",
            file=sys.stderr,
        )
    try:
        load()
        yield endpoint
    finally:
        endpoint.listener.close()


def show(url: str, options: PanelOptions, console: TextIO) -> Thread | None:
    """Open the page in a browser if the output is a terminal and there is a desktop.

    Returns:
        The thread that opens the page; None if the page is not opened.
    """
    has_user = console.isatty() and Machine().has_desktop()
    if not (options.open and has_user):
        return None
    import threading
    import webbrowser

    # With some browsers, the call returns only after the browser is closed.
    opener = threading.Thread(
        target=webbrowser.open, args=(url,), name="tool0-browser", daemon=True
    )
    opener.start()
    return opener


def view(
    description: DescriptionConfig = DescriptionConfig(),
    spawn_z: Metres = SimulationConfig().spawn_z,  # a frozen dataclass
    panel: PanelOptions = PanelOptions(),
) -> None:
    """Show a robot without physics in a web page, in which you can pose its joints.

    Args:
        spawn_z: Height of the robot's root above the ground [m].
    """
    from tool0.description.loading import load_description
    from tool0.panel.server import Panel
    from tool0.panel.view import RobotView

    with contextlib.ExitStack() as exits:
        endpoint = exits.enter_context(listening(panel))
        stop = exits.enter_context(StopSignal())
        robot = RobotView(
            load_description(description, spawn_z=spawn_z), ground=-spawn_z
        )
        exits.enter_context(Panel(robot, endpoint=endpoint))
        print(f"{panel_line(endpoint.url)}\nCtrl-C ends it.", flush=True)
        show(endpoint.url, panel, sys.stdout)
        stop.wait()
