"""``tool0 gazebo``: get a Gazebo 11, see which one would run, remove it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from tool0.cli.installing import OK, print_status, run_subcommand
from tool0.cli.progress import ProgressBar


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    return run_subcommand(
        command,
        {"install": install, "status": status, "uninstall": uninstall},
        arguments,
        "Get a Gazebo 11 to simulate with, see which would run, remove it.",
    )


def install(
    *,
    gui: bool = False,
    private: bool = False,
    mirror: str | None = None,
    keyring: Path | None = None,
) -> int:
    """Get a Gazebo 11 ready to run: the system's, or a private one from Debian 11.

    The private one needs no root: apt fetches and verifies Debian's packages, which
    are unpacked in your data folder.  The next run resumes an interrupted download.

    Args:
        gui: Also what Gazebo's window and cameras draw with.
        private: Make a private one even if the system has a Gazebo 11.
        mirror: Address of a Debian mirror, instead of those that apt here uses.
        keyring: Keys that sign Debian 11, instead of debian-archive-keyring's.
    """
    from tool0.installation.gazebo.install import (
        KEYRING,
        GazeboOptions,
        install_gazebo,
    )
    from tool0.installation.gazebo.installation import NAMED_BY, find_installation

    options = GazeboOptions(
        has_client=gui, is_private=private, mirror=mirror, keyring=keyring or KEYRING
    )
    with ProgressBar() as progress:
        made = install_gazebo(options, progress)
    print(f"ready: Gazebo {made.version} in {made.prefix or made.server.parent.parent}")
    if gui and made.client is None:
        print("it has no gzclient; --private makes a Gazebo that has")
    if find_installation().server != made.server:
        print(f"another Gazebo comes first; to run this one: {NAMED_BY}={made.prefix}")
    return OK


def status(*, format: Literal["text", "json"] = "text") -> int:
    """Print which Gazebo would run, and what is missing; status 1 if none can.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.gazebo.status import gazebo_status

    return print_status(gazebo_status(), format)


def uninstall() -> int:
    """Remove the private Gazebo and what was compiled for any."""
    from tool0.installation.gazebo.install import uninstall_gazebo

    freed = uninstall_gazebo()
    print(f"removed: {freed / 1e6:.0f} MB are free again" if freed else "nothing to do")
    return OK
