"""Finds ROS 1 in a sourced workspace, in RoboStack or in Debian's packages."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from platform import node
from urllib.parse import urlsplit

from tool0.errors import RosUnavailableError

DEBIAN = Path("/usr/lib/python3/dist-packages")
"""Folder of the modules for the Python 3 of Debian and Ubuntu."""
DEFAULT_MASTER = "http://localhost:11311"
SET_UP = (
    "`tool0 ros1 install` installs it on Debian and Ubuntu; on a machine with Noetic, "
    "`source /opt/ros/noetic/setup.bash` first (docs/how-to/ros1.md)"
)


def import_ros() -> None:
    """Make rospy and its messages importable.

    Debian's folder is appended to the search path, so that the origin of all other
    modules does not change.

    Raises:
        RosUnavailableError: If this Python cannot import rospy.
    """
    if importlib.util.find_spec("rospy") is not None:
        return
    if not (DEBIAN / "rospy").is_dir():
        raise RosUnavailableError(f"rospy, which ROS 1 needs, is missing; {SET_UP}")
    try:
        program = Path("/usr/bin/python3").resolve(strict=True)
    except OSError:
        program = Path("python")
    theirs = program.name.removeprefix("python")
    ours = f"{sys.version_info.major}.{sys.version_info.minor}"
    if theirs not in (ours, ""):
        raise RosUnavailableError(
            f"rospy is installed for Python {theirs}, but this is Python {ours}; make "
            "the virtual environment with /usr/bin/python3"
        )
    sys.path.append(str(DEBIAN))
    importlib.invalidate_caches()


def rospy_folder() -> Path | None:
    """Return the folder from which rospy would be imported; None if there is none."""
    spec = importlib.util.find_spec("rospy")
    return None if spec is None or spec.origin is None else Path(spec.origin).parent


def is_of_distribution() -> bool:
    """Return whether the importable ROS comes from the distribution's packages."""
    folder = rospy_folder()
    return folder is not None and folder.parent == DEBIAN


def ros_origin() -> str | None:
    """Return the origin of the importable ROS, such as a distribution or RoboStack."""
    if rospy_folder() is None:
        return None
    if is_of_distribution():
        return "the distribution's"
    if (Path(sys.prefix) / "conda-meta").is_dir():
        return "RoboStack"
    return f"ROS {os.environ.get('ROS_DISTRO', 'of a workspace')}"


# --- its packages ---


def prefixes() -> tuple[Path, ...]:
    """Return the folders of installed ROS packages, with workspaces first."""
    named = os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    folders = [Path(name) for name in named if name]
    own = package_prefix("rospy")
    return tuple(dict.fromkeys(folders if own is None else [*folders, own]))


def message_folders(package: str) -> list[Path]:
    """Return the folders that contain the ``.msg`` files of a package."""
    folders = (root / "share" / package / "msg" for root in prefixes())
    return [folder for folder in folders if folder.is_dir()]


def find_node(name: str) -> Path | None:
    """Return the path of the node ``package/program``, as rosrun finds it."""
    files = (root / "lib" / name for root in prefixes())
    return next((file for file in files if os.access(file, os.X_OK)), None)


def package_prefix(module: str) -> Path | None:
    """Return the prefix in which the package of a module is installed."""
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        return None
    manifest = Path("share", module, "package.xml")
    folders = Path(spec.origin).parents
    return next((folder for folder in folders if (folder / manifest).is_file()), None)


def package_version(module: str) -> str | None:
    """Return the version in the manifest of a module's package."""
    from xml.etree import ElementTree

    prefix = package_prefix(module)
    if prefix is None:
        return None
    manifest = prefix / "share" / module / "package.xml"
    return ElementTree.parse(manifest).getroot().findtext("version")


# --- its addresses ---


def keep_to_this_machine() -> None:
    """Make ROS listen only on 127.0.0.1, unless the environment requires otherwise.

    The environment requires otherwise if ``ROS_IP`` or ``ROS_HOSTNAME`` is set, or if
    the master is on another machine.
    """
    master = os.environ.setdefault("ROS_MASTER_URI", DEFAULT_MASTER)
    if not {"ROS_IP", "ROS_HOSTNAME"} & os.environ.keys() and is_local(master):
        os.environ["ROS_IP"] = "127.0.0.1"


def is_local(uri: str) -> bool:
    """Return whether a ROS address is on this machine."""
    return urlsplit(uri).hostname in ("localhost", "127.0.0.1", "::1", node())
