"""What a shell is told, for the commands of ROS 1 to know our messages."""

from __future__ import annotations

import os
import shlex

from tool0.errors import RosUnavailableError
from tool0.installation.ros1 import messages
from tool0.installation.ros1.library import import_ros

VARIABLES = ("PYTHONPATH", "ROS_PACKAGE_PATH")


def exports() -> list[str]:
    """Return lines for a POSIX shell; none where every message is installed.

    They append to the variables as they are in the environment, and say no more the
    second time.

    Raises:
        RosUnavailableError: If there is no rospy, or the cache cannot be written.
    """
    import_ros()
    absent = messages.absent_packages()
    if not absent:
        return []
    try:
        folder = messages.generated_packages(absent)
    except OSError as error:
        raise RosUnavailableError(
            f"cannot write the cache: {error}; XDG_CACHE_HOME names another folder"
        ) from None
    return [f"export {name}={_appended(name, str(folder))}" for name in VARIABLES]


def _appended(variable: str, folder: str) -> str:
    entries = os.environ.get(variable, "").split(os.pathsep)
    kept = [entry for entry in entries if entry and not messages.is_generated(entry)]
    return shlex.quote(os.pathsep.join([*kept, folder]))
