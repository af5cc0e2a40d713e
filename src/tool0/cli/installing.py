"""``tool0 doctor | gazebo | ros1``: what is installed here, and how to get the rest."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, Protocol

from tool0.cli.text import ProgressBar, columns

OK, NOT_READY = 0, 1
Format = Literal["text", "json"]


def doctor(*, format: Format = "text") -> int:
    """Print what this machine can run, and the command that installs what is missing.

    Status 1 if it cannot run `tool0 bringup`, that is the robot in MuJoCo.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.doctor.report import examine

    return _print_status(examine(), format)


def _install_gazebo(
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


def _gazebo_status(*, format: Format = "text") -> int:
    """Print which Gazebo would run, and what is missing; status 1 if none can.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.gazebo.status import gazebo_status

    return _print_status(gazebo_status(), format)


def _uninstall_gazebo() -> int:
    """Remove the private Gazebo and what was compiled for any."""
    from tool0.installation.gazebo.install import uninstall_gazebo

    freed = uninstall_gazebo()
    print(f"removed: {freed / 1e6:.0f} MB are free again" if freed else "nothing to do")
    return OK


gazebo = {
    "install": _install_gazebo,
    "status": _gazebo_status,
    "uninstall": _uninstall_gazebo,
}


def _install_ros1(*, rviz: bool = False, dry_run: bool = False) -> int:
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


def _ros1_status(*, format: Format = "text") -> int:
    """Print which ROS 1 is there, and what is missing; status 1 if none can be used.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.ros1.packages import ros1_status

    return _print_status(ros1_status(), format)


def _ros1_env() -> int:
    """Print what makes our messages known to rostopic, rosservice and rosmsg.

    Run ``eval "$(tool0 ros1 env)"`` in the shell.  Nothing is printed where
    control_msgs, controller_manager_msgs and gazebo_msgs are installed.
    """
    from tool0.installation.ros1.messages import shell_exports

    for line in shell_exports():
        print(line)
    return OK


ros1 = {"install": _install_ros1, "status": _ros1_status, "env": _ros1_env}


class InstallationStatus(Protocol):
    """Whether something could run here, and what is missing."""

    @property
    def can_run(self) -> bool: ...

    def as_json(self) -> dict[str, object]: ...

    def rows(self) -> Sequence[Sequence[str]]: ...


def _print_status(status: InstallationStatus, format: Format) -> int:
    """Print it, for people or for programs; return the exit status."""
    if format == "json":
        print(json.dumps(status.as_json()))
    else:
        print(columns(status.rows()), end="")
    return OK if status.can_run else NOT_READY
