"""``tool0 doctor | gazebo | ros1``: show and install optional software."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

from tool0.cli.parameters import AsJson
from tool0.cli.text import ProgressBar, columns, print_json

OK, NOT_READY = 0, 1


def doctor(*, as_json: AsJson = False) -> int:
    """Show which features this machine can run, and how to install missing software.

    Exit status: 1 if this machine cannot run `tool0 bringup` with MuJoCo.

    Args:
        as_json: Print one JSON object.
    """
    from tool0.cli.probes import PROBES
    from tool0.installation.doctor.report import examine

    return print_status(examine(PROBES), as_json=as_json)


def _install_gazebo(
    *,
    gui: bool = False,
    private: bool = False,
    mirror: str | None = None,
    keyring: Path | None = None,
) -> int:
    """Prepare Gazebo 11: use the system's packages, or unpack packages of Debian 11.

    The private copy requires no root access: apt downloads and verifies the packages,
    and tool0 unpacks them in your data folder.  If the download is interrupted, run the
    command again to resume it.

    Args:
        gui: Also install the packages that Gazebo's window and cameras require.
        private: Make a private copy even if the system has Gazebo 11.
        mirror: URL of a Debian mirror, instead of the mirrors in apt's configuration.
        keyring: File with the keys that sign Debian 11, instead of the keys of
            debian-archive-keyring.
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
        print("it has no gzclient; with --private, you get one that has")
    if find_installation().server != made.server:
        print(f"another Gazebo comes first; to run this one: {NAMED_BY}={made.prefix}")
    return OK


def _gazebo_status(*, as_json: AsJson = False) -> int:
    """Show which installation of Gazebo is used, and which components are missing.

    Exit status: 1 if Gazebo cannot be used.

    Args:
        as_json: Print one JSON object.
    """
    from tool0.installation.gazebo.status import gazebo_status

    return print_status(gazebo_status(), as_json=as_json)


def _uninstall_gazebo() -> int:
    """Remove the private Gazebo and the compiled plugins."""
    from tool0.installation.gazebo.install import uninstall_gazebo

    return print_removed(uninstall_gazebo())


gazebo = {
    "install": _install_gazebo,
    "status": _gazebo_status,
    "uninstall": _uninstall_gazebo,
}


def _install_ros1(*, rviz: bool = False, dry_run: bool = False) -> int:
    """Use apt to install the packages that `tool0 bringup --ros1` needs.

    The command supports Debian 12, Debian 13 and Ubuntu 22.04.  With ROS Noetic or
    RoboStack, the command installs nothing, but lists the missing packages.

    Args:
        rviz: Also install RViz.
        dry_run: Only print the apt command.
    """
    from tool0.installation.ros1.install import install_ros1, plan_install

    plan = plan_install(rviz=rviz)
    if not plan.packages:
        print(f"nothing to do: {plan.target} has everything that ROS 1 needs")
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


def _ros1_status(*, as_json: AsJson = False) -> int:
    """Show which ROS 1 distribution is installed, and which packages are missing.

    Exit status: 1 if ROS 1 cannot be used.

    Args:
        as_json: Print one JSON object.
    """
    from tool0.installation.ros1.packages import ros1_status

    return print_status(ros1_status(), as_json=as_json)


def _ros1_env() -> int:
    """Print shell commands that make the generated messages available to ROS tools.

    Run `eval "$(tool0 ros1 env)"` in the shell, so that rostopic, rosservice and rosmsg
    find the messages.  If control_msgs, controller_manager_msgs and gazebo_msgs are
    installed, the command prints nothing.
    """
    from tool0.installation.ros1.messages import shell_exports

    for line in shell_exports():
        print(line)
    return OK


ros1 = {"install": _install_ros1, "status": _ros1_status, "env": _ros1_env}


class InstallationStatus(Protocol):
    """Status of an installation: whether it is usable, and what is missing."""

    @property
    def can_run(self) -> bool: ...

    def as_json(self) -> Mapping[str, object]: ...

    def rows(self) -> Sequence[Sequence[str]]: ...


def print_removed(size: int) -> int:
    """Print the size of the removed files [bytes]; return the exit status."""
    print(f"removed {size / 1e6:.0f} MB" if size else "nothing to remove")
    return OK


def print_status(status: InstallationStatus, *, as_json: bool) -> int:
    """Print the status as text or as JSON; return the exit status."""
    if as_json:
        print_json(status.as_json())
    else:
        print(columns(status.rows()), end="")
    return OK if status.can_run else NOT_READY
