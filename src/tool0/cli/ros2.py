"""``tool0 ros2``: install ROS 2, or show what is installed."""

from __future__ import annotations

from tool0.cli.installing import OK, print_removed, print_status
from tool0.cli.parameters import AsJson
from tool0.cli.text import ProgressBar


def _install_ros2(*, own: bool = False) -> int:
    """Prepare ROS 2 for `tool0 bringup --ros2`: check an installation, or install it.

    If ROS 2 is sourced in this terminal or installed in /opt/ros, the command uses it,
    changes nothing, and lists missing packages.  Otherwise, the command installs rclpy
    and the messages of Kilted from PyPI in your data folder.  The installation requires
    no root access, takes about a minute, and uses 300 MB of disk space.

    Args:
        own: Install tool0's own ROS 2 even if another ROS 2 is installed.
    """
    from tool0.installation.ros2.install import install_ros2
    from tool0.installation.ros2.installation import find_ros2
    from tool0.installation.ros2.status import ros2_status

    found = find_ros2()
    if not own and found is not None and found.kind != "own":
        status = ros2_status()
        print(f"nothing to do: ROS 2 {found.distro} is in {found.prefix}")
        for remedy in status.remedies:
            print(f"it lacks packages; run: {remedy}")
        return OK
    with ProgressBar() as progress:
        made = install_ros2(progress)
    print(f"ready: ROS 2 {made.distro} in {made.prefix}")
    other = find_ros2()
    if other is not None and other.prefix != made.prefix:
        print(f"another ROS 2 comes first: {other.distro} in {other.prefix}")
    return OK


def _ros2_status(*, as_json: AsJson = False) -> int:
    """Show which ROS 2 installation is used, and which packages are missing.

    Exit status: 1 if ROS 2 cannot be used.

    Args:
        as_json: Print one JSON object.
    """
    from tool0.installation.ros2.status import ros2_status

    return print_status(ros2_status(), as_json=as_json)


def _ros2_env() -> int:
    """Print shell commands that make ROS 2 and tool0's node usable in a terminal.

    Run `eval "$(tool0 ros2 env)"` in the terminal.  In this terminal, `python` can then
    import rclpy, and `python -m tool0_ros2` starts the node.
    """
    from tool0.installation.ros2.status import shell_exports

    for line in shell_exports():
        print(line)
    return OK


def _uninstall_ros2() -> int:
    """Remove tool0's own ROS 2."""
    from tool0.installation.ros2.install import uninstall_ros2

    return print_removed(uninstall_ros2())


ros2 = {
    "install": _install_ros2,
    "status": _ros2_status,
    "env": _ros2_env,
    "uninstall": _uninstall_ros2,
}
