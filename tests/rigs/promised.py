"""What a machine may lack, and a run of the tests may promise: ``TOOL0_REQUIRE``."""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import os
import re
import shutil
from typing import NoReturn

import pytest

from tool0.engines.mujoco.gl import make_context
from tool0.errors import RenderError
from tool0.installation.gazebo.status import gazebo_status
from tool0.installation.ros1.packages import required_components, ros1_status
from tool0.installation.ros2.installation import Ros2, find_ros2
from tool0.kernel.library import kernel_status

ROS2 = find_ros2()
"""Of the person who runs the tests: found before tests get folders of their own."""


def absent(part: str, why: str) -> NoReturn:
    """Skip visibly, or fail if this run promised ``part``.

    Parts are browser, gazebo, gl, kernel, ros1, ros2, ur_rtde and zsh.
    """
    if part in os.environ.get("TOOL0_REQUIRE", "").split():
        pytest.fail(f"{why}, which this run promised")
    pytest.skip(f"{why}; `make test` sees to it")


def require_engine(name: str) -> None:
    """Skip visibly, or fail if this run promised it, if there is no Gazebo for it."""
    if name == "gazebo" and not (found := gazebo_status()).can_run:
        absent(name, f"no Gazebo can run here ({'; '.join(found.missing)})")


@functools.cache
def require_gl() -> None:
    """Skip visibly, or fail if this run promised it, if nothing draws pictures."""
    try:
        make_context(8, 8).free()
    except RenderError as error:
        absent("gl", str(error))


def why_lacking(command: str) -> str | None:
    """Return what a command of a page needs and this machine lacks, if anything.

    Fail if this run promised it.
    """
    is_drawn = re.search(r"--(camera|video|format mp4|out|depth|cameras)\b", command)
    has_images = command.startswith("tool0 collect") and "image" in command
    try:
        if "--engine gazebo" in command:
            require_engine("gazebo")
        if "--ros1" in command:
            require_ros()
        if is_drawn or has_images:
            require_gl()
        if command.startswith("roslaunch ") and shutil.which("roslaunch") is None:
            absent("ros1", "there is no roslaunch here")
    except pytest.skip.Exception as skipped:
        return f"{command}: {skipped}"
    return None


def require_kernel() -> ctypes.CDLL:
    """Return the compiled kernel; else skip, or fail if this run promised it."""
    status = kernel_status()
    if status.library is None:
        absent("kernel", status.reason)
    return status.library


def require_ros(*, rviz: bool = False) -> None:
    """Skip visibly, or fail if this run promised it, if ROS 1 is not all here."""
    why = ros1_status().why_not(part.name for part in required_components(rviz=rviz))
    if why is not None:
        absent("ros1", f"not all of ROS 1 is here ({why})")


def require_ros2() -> Ros2:
    """Return the ROS 2; skip visibly, or fail if this run promised it, without one."""
    if ROS2 is None:
        absent("ros2", "no ROS 2 is here")
    return ROS2


def require_ur_rtde() -> None:
    """Skip visibly, or fail if this run promised it, without the clients of ur_rtde."""
    if importlib.util.find_spec("rtde_control") is None:
        absent("ur_rtde", "PyPI has no wheel of ur-rtde for this Python and machine")
