"""``tool0 ros1``: get ROS 1 onto this machine, and see what of it is there."""

from __future__ import annotations

from typing import Literal

import tyro

from tool0.cli.progress import Progress
from tool0.cli.readiness import OK, tell


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    status: int = tyro.extras.subcommand_cli_from_dict(
        {"install": install, "status": status_of_ros, "env": env},
        prog=f"tool0 {command}",
        description="Get ROS 1 onto this machine, and see what of it is there.",
        args=arguments,
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    return status


def install(*, rviz: bool = False, dry_run: bool = False) -> int:
    """Install what ``tool0 bringup --ros1`` uses, by apt.

    That is on Debian 12 and 13 and on Ubuntu 22.04.  Beside a Noetic or a RoboStack it
    installs nothing, and names what that lacks.

    Args:
        rviz: Also RViz, and what it draws with.
        dry_run: Print the command, and do not run it.
    """
    from tool0.installation.ros1.install import carry_out, plan

    found = plan(rviz=rviz)
    if not found.packages:
        print(f"nothing to do: {found.where} has what is needed of ROS 1")
        return OK
    if dry_run:
        print(found.command)
        return OK
    names = " ".join(found.packages)
    print(f"installing ROS 1 by apt, from {found.where}: {names}", flush=True)
    with Progress() as progress:
        carry_out(found, progress)
    print("ready: tool0 bringup --ros1 --roscore")
    return OK


def status_of_ros(*, format: Literal["text", "json"] = "text") -> int:
    """Tell which ROS 1 is there, and what is missing; status 1 if none can be used.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.ros1.readiness import readiness

    return tell(readiness(), format)


def env() -> int:
    """Print what lets rostopic, rosservice and rosmsg know our messages.

    Say ``eval "$(tool0 ros1 env)"`` in the shell.  Nothing is printed where
    control_msgs, controller_manager_msgs and gazebo_msgs are installed.
    """
    from tool0.installation.ros1.shell import exports

    for line in exports():
        print(line)
    return OK
