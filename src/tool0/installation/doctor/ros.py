"""ROS 1 and ROS 2, as far as tool0 speaks them."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING

from tool0.errors import RosUnavailableError
from tool0.installation.doctor.line import Line, State
from tool0.installation.doctor.machine import Machine

if TYPE_CHECKING:
    from tool0.installation.ros1.readiness import Readiness


def ros1(here: Machine) -> list[Line]:
    """Tell whether ``tool0 bringup --ros1`` works, and what else of ROS 1 is there."""
    from tool0.installation.ros1.readiness import readiness

    there = readiness()
    if not there.can_run:
        return [_without_ros1(there)]
    master = f"{there.master} answers"
    if not there.is_master_up:
        master = f"no master answers at {there.master}: add --roscore"
    found = f"rospy {there.version}, {there.source}, {there.rospy}; {master}"
    others = [name for name in there.missing if name != "rviz"]
    remedy = "; ".join(there.remedies)
    return [
        Line(what="ros1", state="ready", found=found),
        Line(
            what="ros1 tools",
            state="missing" if others else "ready",
            found=", ".join(others) or "roscore, rostopic and the like",
            remedy=remedy if others else "",
        ),
        Line(
            what="rviz",
            state="missing" if "rviz" in there.missing else "ready",
            found=here.program("rviz") or "for seeing the robot in RViz",
            remedy=remedy if "rviz" in there.missing else "",
        ),
    ]


def _without_ros1(there: Readiness) -> Line:
    from tool0.installation.ros1.distribution import PYTHON, distribution
    from tool0.installation.ros1.install import plan

    try:
        plan(rviz=False)
    except RosUnavailableError as error:  # it says who packages it, or what is wrong
        is_packaged = there.rospy is not None or distribution()[1] in PYTHON
        state: State = "missing" if is_packaged else "not supported"
        return Line(what="ros1", state=state, found=str(error))
    lacking = [name for names in there.missing.values() for name in names]
    few = ", ".join(lacking[:4]) + ", …" * (len(lacking) > 4)
    return Line(
        what="ros1",
        state="missing",
        found=f"no {few}; for --ros1",
        remedy="tool0 ros1 install --rviz",
    )


def ros2(here: Machine) -> list[Line]:
    """Tell what there is of ROS 2, which tool0 does not speak yet."""
    homes = sorted((here.root / "opt/ros").glob("*/lib/python3*/site-packages/rclpy"))
    distros = [f"{home.parents[3]} with rclpy" for home in homes]
    spec = None if distros else importlib.util.find_spec("rclpy")
    if spec is not None and spec.origin is not None:
        distros = [f"rclpy in {spec.origin}"]
    found = f"by tool0 yet; {', '.join(distros) or 'nothing of it is here'}"
    return [Line(what="ros2", state="not supported", found=found)]
