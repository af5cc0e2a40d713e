"""The services of UR's force_mode_controller."""

from collections.abc import Sequence
from typing import Any

from std_srvs.srv import Trigger

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.control_box import ControlBox
from tool0_ros2.copied import from_quaternion
from tool0_ros2.frames import Frames
from tool0_ros2.messages import optional_module
from tool0_ros2.services import offer, refused

_AXES = ("x", "y", "z", "rx", "ry", "rz")
_SMALLEST, _LARGEST = 1e-6, 100.0
"""Range of the limits in requests [m/s, rad/s, m, rad].  A limit of 0 is replaced by
the smallest limit."""
_NO_TURN = 1e-6
"""Absolute value below which a component of a quaternion is treated as zero.  A zero
quaternion is refused."""


class ForceModePart:
    """Services ``~/start_force_mode`` and ``~/stop_force_mode``."""

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        prefix = context.parameters.get("tf_prefix") or context.names.prefix
        self._box = ControlBox(context, prefix)
        self._frames = Frames(context, self._box)
        self._services = [offer(context, Trigger, "stop_force_mode", self._stop)]
        services = optional_module(context, "ur_msgs.srv", context.name)
        if services is not None and hasattr(services, "SetForceMode"):
            self._services.append(
                offer(context, services.SetForceMode, "start_force_mode", self._start)
            )
        elif services is not None:
            context.report.warning(
                "left out: start_force_mode, since this ur_msgs has no SetForceMode"
            )

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Publish nothing, because this part has only services."""

    def close(self) -> None:
        self._frames.close()
        for service in self._services:
            self._context.node.destroy_service(service)

    def _start(self, request: Any) -> str:
        kind: Any = int(request.type)
        if kind not in (1, 2, 3):
            raise refused(f"the type must be 1, 2 or 3, got {kind}")
        selection = [getattr(request, f"selection_vector_{axis}") for axis in _AXES]
        speeds = _six(request.speed_limits.linear, request.speed_limits.angular)
        deviations = map(float, request.deviation_limits)
        self._context.connection.call(
            requests.start_force_mode(
                arm=self._box.arm,
                controller=self._context.name,
                frame=self._task_frame(request.task_frame),
                selection=selection,
                wrench=_six(request.wrench.force, request.wrench.torque),
                limits=[
                    _limit(speed if is_free else deviation)
                    for is_free, speed, deviation in zip(selection, speeds, deviations)
                ],
                kind=kind,
                tcp=self._box.read()["tcp"],
                damping=float(request.damping_factor),
                gain_scaling=float(request.gain_scaling),
            )
        )
        return ""

    def _stop(self, request: Any) -> str:
        self._context.connection.call(
            requests.end_force_mode(arm=self._box.arm, controller=self._context.name)
        )
        return "force mode has ended"

    def _task_frame(self, stamped: Any) -> list[float]:
        """Return the current pose of the task frame in the arm's base frame."""
        place, turn = stamped.pose.position, stamped.pose.orientation
        quat_wxyz = (turn.w, turn.x, turn.y, turn.z)
        if all(abs(part) < _NO_TURN for part in quat_wxyz):
            raise refused("the quaternion of the task frame has zeros only")
        T_base_frame = self._frames.in_base(stamped.header.frame_id)
        pose = from_quaternion((place.x, place.y, place.z), quat_wxyz)
        found = T_base_frame @ pose
        return [*found.position, *found.rotation_vector]


def _six(linear: Any, angular: Any) -> list[float]:
    return [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]


def _limit(value: float) -> float:
    """Return a limit for a request.  The simulation refuses negative limits."""
    return value if value < 0.0 else min(max(value, _SMALLEST), _LARGEST)
