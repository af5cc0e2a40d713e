"""Converts between requests and ROS messages, which depend on the distribution."""

import math
from collections.abc import Iterable, Sequence
from importlib import import_module
from types import ModuleType
from typing import Any

from builtin_interfaces.msg import Duration

from tool0_ros2.clock import NANOSECONDS, to_seconds
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.copied import Transform, Vector3
from tool0_ros2.requests import TrajectoryPoint

INVALID_GOAL = -1
"""Error code INVALID_GOAL in control_msgs/FollowJointTrajectory."""


def fill(item: Any, /, **values: Any) -> Any:
    """Set the fields that exist in this distribution, and return the message."""
    fields = item.get_fields_and_field_types()
    for name, value in values.items():
        if name in fields:
            setattr(item, name, value)
    return item


def fill_frame(place: Any, turn: Any, frame: Transform) -> None:
    """Set a position or translation, and a rotation, from a frame."""
    place.x, place.y, place.z = map(float, frame.position)
    turn.w, turn.x, turn.y, turn.z = frame.quat_wxyz


def to_vector(values: Sequence[float]) -> Vector3:
    """Return three numbers from a response as a tuple."""
    x, y, z = values
    return x, y, z


def rejected(reason: str) -> RequestFailedError:
    """Return the error for a goal that the node rejects."""
    return RequestFailedError("GoalRejectedError", reason, INVALID_GOAL)


def to_duration(seconds: float) -> Duration:
    """Return a builtin_interfaces/Duration."""
    whole, part = divmod(round(seconds * NANOSECONDS), NANOSECONDS)
    return Duration(sec=whole, nanosec=part)


def to_points(points: Sequence[Any]) -> list[TrajectoryPoint]:
    """Return trajectory_msgs/JointTrajectoryPoints as values of a request.

    Raises:
        RequestFailedError: If a point has efforts, or if a number is not finite.  JSON
            has only finite numbers.
    """
    found = []
    for k, point in enumerate(points):
        if point.effort:
            raise rejected(
                f"point {k + 1} has an effort field, which no controller here follows: "
                "leave it empty"
            )
        for name in ("positions", "velocities", "accelerations"):
            numbers = getattr(point, name)
            if not all(map(math.isfinite, numbers)):
                raise rejected(
                    f"{name} of point {k + 1} must be finite, got {list(numbers)}"
                )
        value: TrajectoryPoint = {
            "positions": point.positions.tolist(),
            "velocities": point.velocities.tolist() or None,
            "accelerations": point.accelerations.tolist() or None,
            "time_from_start": to_seconds(point.time_from_start),
        }
        found.append(value)
    return found


def to_tolerances(tolerances: Iterable[Any]) -> dict[str, list[float]]:
    """Return control_msgs/JointTolerances as values, by joint."""
    found = {
        item.name: [item.position, item.velocity, item.acceleration]
        for item in tolerances
    }
    for name, values in found.items():
        if not all(map(math.isfinite, values)):
            raise rejected(f"the tolerances of {name} must be finite, got {values}")
    return found


def optional_module(context: Any, module: str, use: str) -> ModuleType | None:
    """Import messages.  If the package is missing, log a warning and return None."""
    try:
        return import_module(module)
    except ImportError:
        package = module.partition(".")[0]
        debian = f"ros-$ROS_DISTRO-{package.replace('_', '-')}"
        context.node.get_logger().warning(
            f"{use}: what needs {package} is left out, since that package is not "
            f"installed; run: sudo apt install {debian}"
        )
        return None
