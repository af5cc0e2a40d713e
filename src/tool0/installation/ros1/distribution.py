"""Which distribution this machine runs, and what it knows of ROS 1."""

from __future__ import annotations

import platform
import sys
from typing import Final

from tool0.errors import RosUnavailableError

PYTHON: Final = {"bookworm": "3.11", "trixie": "3.13", "jammy": "3.10"}
"""Release that packages ROS 1 → the Python that its packages are for.

Debian 12 and 13, and Ubuntu 22.04.  Ubuntu removed ROS 1 before 24.04:
https://bugs.launchpad.net/ubuntu/+source/ros-catkin/+bug/2063103
"""
_ELSEWHERE: Final = (
    "RoboStack runs on any Linux, and a container or another machine with Debian 12 "
    "or 13 can be used over ROS_MASTER_URI (docs/ros1.md)"
)
_REMEDIES: Final = {
    "focal": (
        "Ubuntu 20.04 has ROS 1 as Noetic: install that from its own packages and "
        "`source /opt/ros/noetic/setup.bash`; docs/ros1.md has the rest"
    ),
}


def check_distribution() -> None:
    """See that the distribution packages ROS 1, for the Python that runs this.

    Raises:
        RosUnavailableError: If not, with the ways that are left.
    """
    name, codename = distribution()
    theirs = PYTHON.get(codename)
    if theirs is None:
        remedy = _REMEDIES.get(codename, _ELSEWHERE)
        raise RosUnavailableError(
            f"{name} has no packages of ROS 1 that tool0 knows of; Debian 12 and 13 "
            f"and Ubuntu 22.04 have. {remedy}"
        )
    ours = f"{sys.version_info.major}.{sys.version_info.minor}"
    if ours != theirs:
        raise RosUnavailableError(
            f"the packages of {name} are for Python {theirs}, and this is Python "
            f"{ours} ('{sys.prefix}'). Make a virtual environment of the "
            "distribution's own: rm -rf .venv && make setup PYTHON=/usr/bin/python3, "
            "or /usr/bin/python3 -m venv FOLDER and FOLDER/bin/pip install ."
        )


def distribution() -> tuple[str, str]:
    """Return the name for people, and the codename of the release it is built on."""
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        return platform.system(), ""
    # Mint and its like name what they are built on.
    for key in ("UBUNTU_CODENAME", "DEBIAN_CODENAME", "VERSION_CODENAME"):
        if key in release:
            return release["PRETTY_NAME"], release[key]
    return release["PRETTY_NAME"], ""
