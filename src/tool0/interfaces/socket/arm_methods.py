"""The methods for the arm, as ``methods.py`` has all others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from tool0.description.transform import Pose, Transform
from tool0.errors import ControlError, did_you_mean
from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.served_robot import ServedArm, ServedGoal, ServedRobot
from tool0.interfaces.socket.wire import Json


def _list(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    rows = [
        {"name": name, "tip": arm.tip, **_as_json(arm.pose())}
        for name, arm in robot.arms.items()
    ]
    return {"arms": rows}


def _pose(robot: ServedRobot, params: Params) -> Json:
    arm = _arm(robot, params)
    tip, relative_to = params.optional_text("tip"), params.optional_text("relative_to")
    params.finish()
    return _as_json(arm.pose(tip=tip, relative_to=relative_to))


def _move_to(robot: ServedRobot, params: Params) -> ServedGoal:
    arm, pose = _arm(robot, params), _target(params)
    options = _given(params, "speed")
    params.finish()
    return arm.move_to(pose, **options)


def _move_linear(robot: ServedRobot, params: Params) -> ServedGoal:
    arm, pose = _arm(robot, params), _target(params)
    options = _given(params, "speed", "acceleration", "angular_speed")
    params.finish()
    return arm.move_linear(pose, **options)


def _arm(robot: ServedRobot, params: Params) -> ServedArm:
    """Return the arm that is named, or the only one."""
    name = params.optional_text("arm")
    if name is None:
        return robot.arm
    if name not in robot.arms:
        raise ControlError(f"no arm '{name}'{did_you_mean(name, set(robot.arms))}")
    return robot.arms[name]


def _target(params: Params) -> Pose:
    return Pose(xyz=params.vector("xyz"), rpy=params.vector("rpy", (0.0, 0.0, 0.0)))


def _given(params: Params, *numbers: str) -> dict[str, Any]:  # values of two types
    """Return what was not left out: the façade has the defaults."""
    values: Mapping[str, float | str | None] = {
        "tip": params.optional_text("tip"),
        "relative_to": params.optional_text("relative_to"),
        **{name: params.optional_number(name) for name in numbers},
    }
    return {name: value for name, value in values.items() if value is not None}


def _as_json(pose: Transform) -> Json:
    return {"position": list(pose.position), "quat_wxyz": list(pose.quat_wxyz)}


ARM_CALLS: Final[dict[str, Callable[[ServedRobot, Params], Json]]] = {
    "arm.list": _list,
    "arm.pose": _pose,
}
ARM_GOALS: Final[dict[str, Callable[[ServedRobot, Params], ServedGoal]]] = {
    "arm.move_to": _move_to,
    "arm.move_linear": _move_linear,
}
