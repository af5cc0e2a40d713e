"""The arm of a robot that runs in another process."""

from __future__ import annotations

from typing import final

from tool0.description.transform import Pose, Transform, from_quaternion
from tool0.interfaces.socket.requests import Call, RemoteGoal, Start
from tool0.interfaces.socket.wire import Json


@final
class RemoteArm:
    """An arm there, with the verbs of ``robot.arm`` in this process.

    ``arm`` names one of several.  Everything else is as there.
    """

    def __init__(self, call: Call, start: Start) -> None:
        self._call = call
        self._start = start

    def poses(self) -> dict[str, Transform]:
        """Return where the flange of each arm is, by the flange's name."""
        rows = self._call("arm.list")["arms"]
        return {row["tip"]: _transform(row) for row in rows}

    def pose(
        self,
        *,
        tip: str | None = None,
        relative_to: str | None = None,
        arm: str | None = None,
    ) -> Transform:
        """Return where ``tip`` is, in the root or in ``relative_to``."""
        answer = self._call("arm.pose", tip=tip, relative_to=relative_to, arm=arm)
        return _transform(answer)

    def move_to(
        self,
        pose: Pose,
        *,
        speed: float | None = None,
        tip: str | None = None,
        relative_to: str | None = None,
        arm: str | None = None,
    ) -> RemoteGoal:
        """Send ``tip`` to ``pose``, the joints by their fastest way."""
        return self._start(
            "arm.move_to",
            xyz=list(pose.xyz),
            rpy=list(pose.rpy),
            speed=speed,
            tip=tip,
            relative_to=relative_to,
            arm=arm,
        )

    def move_linear(
        self,
        pose: Pose,
        *,
        speed: float | None = None,
        acceleration: float | None = None,
        angular_speed: float | None = None,
        tip: str | None = None,
        relative_to: str | None = None,
        arm: str | None = None,
    ) -> RemoteGoal:
        """Send ``tip`` to ``pose`` along a straight line."""
        return self._start(
            "arm.move_linear",
            xyz=list(pose.xyz),
            rpy=list(pose.rpy),
            speed=speed,
            acceleration=acceleration,
            angular_speed=angular_speed,
            tip=tip,
            relative_to=relative_to,
            arm=arm,
        )


def _transform(answer: Json) -> Transform:
    return from_quaternion(answer["position"], answer["quat_wxyz"])
