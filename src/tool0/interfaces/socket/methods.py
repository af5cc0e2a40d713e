"""The methods a peer may call, each from checked parameters to one façade call.

``goal.*`` is not here: goals belong to a connection, so ``server.py`` keeps them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Final

from tool0.control.trajectory import TrajectoryPoint
from tool0.errors import ModelError, TransportError
from tool0.interfaces.socket.arm_methods import ARM_CALLS, ARM_GOALS
from tool0.interfaces.socket.camera_methods import CAMERA_CALLS
from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.scene_methods import SCENE_CALLS
from tool0.interfaces.socket.served_robot import (
    ServedGeometry,
    ServedGoal,
    ServedGripper,
    ServedRobot,
)
from tool0.interfaces.socket.wire import Json
from tool0.interfaces.socket.wrench_methods import WRENCH_CALLS


def _state(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    joints, snapshot = robot.joint_state, robot.snapshot
    return {
        "time": robot.time,
        "is_paused": snapshot.is_paused,
        "is_stopped": snapshot.is_stopped,
        "real_time_factor": snapshot.real_time_factor,
        "overruns": snapshot.overruns,
        "fault": snapshot.fault,
        "position": dict(joints.position),
        "velocity": dict(joints.velocity),
        "effort": dict(joints.effort),
        "grippers": {name: _grasp(gripper) for name, gripper in robot.grippers.items()},
    }


def _grasp(gripper: ServedGripper) -> Json:
    state = gripper.state
    return {
        "motion": state.motion,
        "opening": state.opening,
        "width": state.width,
        "gobj": state.gobj,
    }


def _gripper_state(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    return _grasp(robot.gripper)


def _summary(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    return dict(robot.summary())


def _controllers_list(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    rows = [
        {
            "name": row.name,
            "type": row.type,
            "state": row.state,
            "claimed": [[kind, list(joints)] for kind, joints in row.claimed],
        }
        for row in robot.controllers()
    ]
    return {"controllers": rows}


def _controllers_load(robot: ServedRobot, params: Params) -> Json:
    name = params.text("name")
    params.finish()
    robot.load(name)
    return {}


def _controllers_unload(robot: ServedRobot, params: Params) -> Json:
    name = params.text("name")
    params.finish()
    robot.unload(name)
    return {}


def _controllers_switch(robot: ServedRobot, params: Params) -> Json:
    start, stop = params.names("start"), params.names("stop")
    strict = params.flag("strict", default=True)
    params.finish()
    robot.switch(start=start, stop=stop, strict=strict)
    return {}


def _query_state(robot: ServedRobot, params: Params) -> Json:
    name = params.text("controller")
    time = params.optional_number("time")
    params.finish()
    point = robot.controller(name).query_state(robot.time if time is None else time)
    return {item.name: getattr(point, item.name) for item in fields(point)}


def _pause(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    robot.pause()
    return {}


def _resume(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    robot.resume()
    return {}


def _step(robot: ServedRobot, params: Params) -> Json:
    ticks = params.count("ticks", default=1)
    params.finish()
    robot.step(ticks)
    return {"time": robot.time}


def _reset(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    robot.reset()
    return {}


def _estop(robot: ServedRobot, params: Params) -> Json:
    engaged = params.flag("engaged", default=True)
    params.finish()
    robot.emergency_stop(engaged)
    return {}


def _follow(robot: ServedRobot, params: Params) -> ServedGoal:
    name = params.text("controller")
    points = [_point(item) for item in params.objects("points")]
    joint_names = params.optional_names("joint_names")
    stamp = params.optional_number("stamp")
    path_tolerance = params.number_by_name("path_tolerance")
    goal_tolerance = params.number_by_name("goal_tolerance")
    goal_time_tolerance = params.optional_number("goal_time_tolerance")
    params.finish()
    return robot.controller(name).follow(
        points,
        joint_names=joint_names,
        stamp=stamp,
        path_tolerance=path_tolerance,
        goal_tolerance=goal_tolerance,
        goal_time_tolerance=goal_time_tolerance,
    )


def _point(item: Params) -> TrajectoryPoint:
    point = TrajectoryPoint(
        positions=item.numbers("positions"),
        velocities=item.optional_numbers("velocities"),
        accelerations=item.optional_numbers("accelerations"),
        time_from_start=item.number("time_from_start", 0.0),
    )
    item.finish()
    return point


def _grip(robot: ServedRobot, params: Params) -> ServedGoal:
    opening = params.optional_number("opening")
    position = params.optional_number("position")
    speed = params.optional_number("speed")
    force = params.optional_number("force")
    effort = params.optional_number("effort")
    params.finish()
    gripper = robot.gripper
    if (opening is None) == (position is None):
        raise TransportError("gripper.move: give 'opening' [m] or 'position' [rad]")
    if opening is None:
        opening = _opening_at(position or 0.0, gripper.geometry)
    return gripper.move(opening=opening, speed=speed, force=force, effort=effort)


def _opening_at(position: float, geometry: ServedGeometry) -> float:
    """Return the opening at a joint position that the fingers can reach.

    ``opening`` is periodic and a little more than ``max_opening`` at the joint's
    end: what counts is whether the way back leads to the same position.
    """
    limit = geometry.max_opening
    opening = min(max(geometry.opening(position), 0.0), limit)
    if not abs(geometry.position(opening) - position) <= 0.02:
        ends = sorted((geometry.position(limit), geometry.position(0.0)))
        raise ModelError(
            f"gripper position {position} rad is outside "
            f"[{ends[0]:.4f}, {ends[1]:.4f}] rad"
        )
    return opening


CALLS: Final[dict[str, Callable[[ServedRobot, Params], Json]]] = {
    "state": _state,
    "summary": _summary,
    "controllers.list": _controllers_list,
    "controllers.load": _controllers_load,
    "controllers.unload": _controllers_unload,
    "controllers.switch": _controllers_switch,
    "controller.query_state": _query_state,
    "gripper.state": _gripper_state,
    "sim.pause": _pause,
    "sim.resume": _resume,
    "sim.step": _step,
    "sim.reset": _reset,
    "sim.estop": _estop,
    **ARM_CALLS,
    **CAMERA_CALLS,
    **SCENE_CALLS,
    **WRENCH_CALLS,
}
"""Methods that are answered at once."""

GOALS: Final[dict[str, Callable[[ServedRobot, Params], ServedGoal]]] = {
    "controller.follow": _follow,
    "gripper.move": _grip,
    **ARM_GOALS,
}
"""Methods that start a goal; the answer is ``{"goal": number}``."""
