"""``tool0 gazebo``: get a Gazebo 11, see which one would run, remove it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import tyro

from tool0.cli.progress import Progress
from tool0.cli.readiness import OK, tell


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    status: int = tyro.extras.subcommand_cli_from_dict(
        {"install": install, "status": status_of_gazebo, "uninstall": uninstall},
        prog=f"tool0 {command}",
        description="Get a Gazebo 11 to simulate with, see which would run, remove it.",
        args=arguments,
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    return status


def install(
    *,
    gui: bool = False,
    private: bool = False,
    mirror: str | None = None,
    keyring: Path | None = None,
) -> int:
    """Get a Gazebo 11 ready to run: the system's, or a private one from Debian 11.

    The private one needs no root: apt fetches and verifies Debian's packages, which
    are unpacked in your data folder.  An interrupted download goes on.

    Args:
        gui: Also what Gazebo's window and cameras draw with.
        private: Make a private one even if the system has a Gazebo 11.
        mirror: Address of a Debian mirror, instead of those that apt here uses.
        keyring: Keys that sign Debian 11, instead of debian-archive-keyring's.
    """
    from tool0.installation.gazebo.install import KEYRING, Wish, ready
    from tool0.installation.gazebo.installation import NAMED_BY, find_installation

    wish = Wish(
        has_client=gui, is_private=private, mirror=mirror, keyring=keyring or KEYRING
    )
    with Progress() as progress:
        made = ready(wish, progress)
    print(f"ready: Gazebo {made.version} in {made.prefix or made.server.parent.parent}")
    if gui and made.client is None:
        print("it has no gzclient; --private makes a Gazebo that has")
    if find_installation().server != made.server:
        print(f"another Gazebo comes first; to run this one: {NAMED_BY}={made.prefix}")
    return OK


def status_of_gazebo(*, format: Literal["text", "json"] = "text") -> int:
    """Tell which Gazebo would run, and what is missing; status 1 if none can.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.gazebo.readiness import readiness

    return tell(readiness(), format)


def uninstall() -> int:
    """Remove the private Gazebo and what was compiled for any."""
    from tool0.installation.gazebo.install import uninstall as remove

    freed = remove()
    print(f"removed: {freed / 1e6:.0f} MB are free again" if freed else "nothing to do")
    return OK
