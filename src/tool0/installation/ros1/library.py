"""Where ROS 1 is: in a sourced workspace, a RoboStack, or Debian's packages."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from platform import node
from urllib.parse import urlsplit

from tool0.errors import RosUnavailableError

DEBIAN = Path("/usr/lib/python3/dist-packages")
"""Where Debian and Ubuntu put the modules of their own Python 3."""
DEFAULT_MASTER = "http://localhost:11311"
SET_UP = (
    "`tool0 ros1 install` installs it on Debian and Ubuntu; on a machine with Noetic, "
    "`source /opt/ros/noetic/setup.bash` first (docs/ros1.md)"
)


def import_ros() -> None:
    """Make rospy and its messages importable.

    Debian's folder is appended, so that everything else is imported from where it was
    before.

    Raises:
        RosUnavailableError: If there is no rospy that this Python can import.
    """
    if importlib.util.find_spec("rospy") is not None:
        return
    if not (DEBIAN / "rospy").is_dir():
        raise RosUnavailableError(f"ROS 1 needs rospy, which is not here; {SET_UP}")
    theirs = system_python()
    ours = f"{sys.version_info.major}.{sys.version_info.minor}"
    if theirs not in (ours, None):
        raise RosUnavailableError(
            f"rospy is installed for Python {theirs}, and this is Python {ours}; make "
            "the virtual environment with /usr/bin/python3"
        )
    sys.path.append(str(DEBIAN))
    importlib.invalidate_caches()


def rospy_folder() -> Path | None:
    """Return where rospy would be imported from."""
    spec = importlib.util.find_spec("rospy")
    return None if spec is None or spec.origin is None else Path(spec.origin).parent


def is_of_distribution() -> bool:
    """Return whether the ROS that is importable is of the distribution's packages."""
    folder = rospy_folder()
    return folder is not None and folder.parent == DEBIAN


def ros_origin() -> str | None:
    """Return the origin of the ROS that is importable: a distribution, RoboStack, …."""
    if rospy_folder() is None:
        return None
    if is_of_distribution():
        return "the distribution's"
    if (Path(sys.prefix) / "conda-meta").is_dir():
        return "RoboStack"
    return f"ROS {os.environ.get('ROS_DISTRO', 'of a workspace')}"


def keep_to_this_machine() -> None:
    """Make ROS listen on 127.0.0.1 alone, unless the environment says otherwise.

    It does if ``ROS_IP`` or ``ROS_HOSTNAME`` is set, or the master is elsewhere.
    """
    master = os.environ.setdefault("ROS_MASTER_URI", DEFAULT_MASTER)
    if not {"ROS_IP", "ROS_HOSTNAME"} & os.environ.keys() and is_local(master):
        os.environ["ROS_IP"] = "127.0.0.1"


def is_local(uri: str) -> bool:
    """Return whether an address of ROS is one of this machine."""
    return urlsplit(uri).hostname in ("localhost", "127.0.0.1", "::1", node())


def system_python() -> str | None:
    """Return the version of the Python that Debian's folder is for, as 3.11."""
    try:
        name = Path("/usr/bin/python3").resolve(strict=True).name
    except OSError:
        return None
    return name.removeprefix("python") or None
