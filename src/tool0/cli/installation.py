"""``tool0 doctor``, ``gazebo`` and ``ros1``: what this machine has, and the rest.

Status 1 means that something cannot run here.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tool0.cli.parsing import parse
from tool0.cli.progress import ProgressBar
from tool0.cli.text import columns

if TYPE_CHECKING:
    from tool0.installation.doctor.report import DoctorReport
    from tool0.installation.gazebo.status import GazeboStatus
    from tool0.installation.ros1.packages import Ros1Status

OK, NOT_READY = 0, 1


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    if command == "doctor":
        # Without options, without tyro, which may be what is missing.
        return parse(doctor, command, arguments) if arguments else doctor()
    import tyro

    subcommands: dict[str, Callable[..., int]]
    if command == "gazebo":
        about = "Get a Gazebo 11 to simulate with, see which would run, remove it."
        subcommands = {"install": install_gazebo, "status": gazebo_status}
        subcommands["uninstall"] = uninstall_gazebo
    else:
        about = "Get ROS 1 onto this machine, and see what of it is there."
        subcommands = {"install": install_ros1, "status": ros1_status}
        subcommands["env"] = ros1_environment
    status: int = tyro.extras.subcommand_cli_from_dict(
        subcommands,
        prog=f"tool0 {command}",
        description=about,
        args=arguments,
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    return status


def _print_status(
    status: DoctorReport | GazeboStatus | Ros1Status, format: Literal["text", "json"]
) -> int:
    if format == "json":
        print(json.dumps(status.as_json()))
    else:
        print(columns(status.rows()), end="")
    return OK if status.can_run else NOT_READY


def doctor(*, format: Literal["text", "json"] = "text") -> int:
    """Print what this machine can run, and the command that installs what is missing.

    Status 1 if it cannot run `tool0 bringup`, that is the robot in MuJoCo.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.doctor.report import examine

    return _print_status(examine(), format)


# --- tool0 gazebo ---


def install_gazebo(
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
    from tool0.installation.gazebo.install import KEYRING, install_gazebo
    from tool0.installation.gazebo.installation import NAMED_BY, find_installation

    with ProgressBar() as progress:
        made = install_gazebo(
            progress,
            has_client=gui,
            is_private=private,
            mirror=mirror,
            keyring=keyring or KEYRING,
        )
    print(f"ready: Gazebo {made.version} in {made.prefix or made.server.parent.parent}")
    if gui and made.client is None:
        print("it has no gzclient; --private makes a Gazebo that has")
    if find_installation().server != made.server:
        print(f"another Gazebo comes first; to run this one: {NAMED_BY}={made.prefix}")
    return OK


def gazebo_status(*, format: Literal["text", "json"] = "text") -> int:
    """Print which Gazebo would run, and what is missing; status 1 if none can.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.gazebo.status import gazebo_status

    return _print_status(gazebo_status(), format)


def uninstall_gazebo() -> int:
    """Remove the private Gazebo and what was compiled for any."""
    from tool0.installation.gazebo.install import uninstall_gazebo

    freed = uninstall_gazebo()
    print(f"removed: {freed / 1e6:.0f} MB are free again" if freed else "nothing to do")
    return OK


# --- tool0 ros1 ---


def install_ros1(*, rviz: bool = False, dry_run: bool = False) -> int:
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


def ros1_status(*, format: Literal["text", "json"] = "text") -> int:
    """Print which ROS 1 is there, and what is missing; status 1 if none can be used.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.ros1.packages import ros1_status

    return _print_status(ros1_status(), format)


def ros1_environment() -> int:
    """Print what makes our messages known to rostopic, rosservice and rosmsg.

    Run ``eval "$(tool0 ros1 env)"`` in the shell.  Nothing is printed where
    control_msgs, controller_manager_msgs and gazebo_msgs are installed.
    """
    from tool0.installation.ros1.messages import shell_exports

    for line in shell_exports():
        print(line)
    return OK
