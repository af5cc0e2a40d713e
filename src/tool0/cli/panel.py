"""The panel of a command: where it listens, and the browser that shows it."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from threading import Thread

    from tool0.cli.options import PanelOptions
    from tool0.interfaces.panel.address import Door
    from tool0.interfaces.panel.server import Panel
    from tool0.interfaces.panel.source import PanelSource
    from tool0.runtime.robot import Robot


def door_of(options: PanelOptions) -> Door:
    """Listen where the options say, and warn if that lets others in."""
    from tool0.interfaces.panel.address import open_door
    from tool0.interfaces.panel.server import load

    door = open_door(options.panel_host, options.panel_port)
    if door.token is not None:
        print(
            f"tool0: warning: the panel listens at {door.host}, port {door.port}; "
            "whoever knows its address with the token can drive the robot",
            file=sys.stderr,
        )
    load()
    return door


@contextlib.contextmanager
def served(source: Robot | PanelSource, door: Door) -> Iterator[Panel]:
    """Serve the panel at ``door``."""
    from tool0.interfaces.panel.server import Panel, is_page_built

    if not is_page_built():
        print(
            "tool0: warning: the panel's page is not built; `make run` builds it",
            file=sys.stderr,
        )
    with Panel(source, door=door) as panel:
        yield panel


def show(url: str, options: PanelOptions, console: TextIO) -> Thread | None:
    """Open the page in a browser, where a person sits before a desktop.

    Returns:
        The thread that opens it; None if there is nobody to see it.
    """
    from tool0.interfaces.panel.probes import has_desktop

    is_seen = console.isatty() and has_desktop(os.environ, sys.platform)
    if not (options.open and is_seen):
        return None
    import threading
    import webbrowser

    # Some browsers come back only when they are closed.
    opener = threading.Thread(
        target=webbrowser.open, args=(url,), name="tool0-browser", daemon=True
    )
    opener.start()
    return opener
