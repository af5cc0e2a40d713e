"""``tool0 ros1``: get ROS 1 onto this machine, and see what of it is there."""

from __future__ import annotations

from typing import Literal

from tool0.cli.installing import OK, print_status, run_subcommand
from tool0.cli.progress import ProgressBar


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    return run_subcommand(
        command,
        {"install": install, "status": status, "env": env},
        arguments,
        "Get ROS 1 onto this machine, and see what of it is there.",
    )


def install(*, rviz: bool = False, dry_run: bool = False) -> int:
    """Install what ``tool0 bringup --ros1`` uses, by apt.

    That is on Debian 12 and 13 and on Ubuntu 22.04.  Beside a Noetic or a RoboStack it
    installs nothing, and names what that lacks.

    Args:
        rviz: Also RViz, and what it draws with.
        dry_run: Print the command, and do not run it.
    """
    from tool0.installation.ros1.install import install_ros1, plan_install

    plan = plan_install(rviz=rviz)
    if not plan.packages:
        print(f"nothing to do: {plan.target} has what is needed of ROS 1")
        return OK
    if dry_run:
        print(plan.command)
        return OK
    names = " ".join(plan.packages)
    print(f"installing ROS 1 by apt, from {plan.target}: {names}", flush=True)
    with ProgressBar() as progress:
        install_ros1(plan, progress)
    print("ready: tool0 bringup --ros1 --roscore")
    return OK


def status(*, format: Literal["text", "json"] = "text") -> int:
    """Print which ROS 1 is there, and what is missing; status 1 if none can be used.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.ros1.status import ros1_status

    return print_status(ros1_status(), format)


def env() -> int:
    """Print what makes our messages known to rostopic, rosservice and rosmsg.

    Run ``eval "$(tool0 ros1 env)"`` in the shell.  Nothing is printed where
    control_msgs, controller_manager_msgs and gazebo_msgs are installed.
    """
    from tool0.installation.ros1.messages import shell_exports

    for line in shell_exports():
        print(line)
    return OK
