"""The methods a peer may call, each from checked parameters to one façade call.

``goal.*`` is not here: goals belong to a connection, so ``server.py`` keeps them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from tool0.control.trajectory import TrajectoryPoint
from tool0.remote.params import Params
from tool0.remote.served_robot import ServedGoal, ServedRobot
from tool0.remote.wire import Json


def _state(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    joints = robot.joint_state
    return {
        "time": robot.time,
        "position": dict(joints.position),
        "velocity": dict(joints.velocity),
        "effort": dict(joints.effort),
    }


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
            "claimed": list(row.claimed),
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
    motion = robot.controller(name).query_state(robot.time if time is None else time)
    return {
        "joint_names": list(motion.joint_names),
        "positions": [float(value) for value in motion.positions],
    }


def _pause(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    robot.pause()
    return {}


def _resume(robot: ServedRobot, params: Params) -> Json:
    params.finish()
    robot.resume()
    return {}


def _step(robot: ServedRobot, params: Params) -> Json:
    count = params.count("count", default=1)
    params.finish()
    robot.step(count)
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
    path_tolerance = params.tolerances("path_tolerance")
    goal_tolerance = params.tolerances("goal_tolerance")
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
        time_from_start=item.number("time_from_start", default=0.0),
    )
    item.finish()
    return point


def _grip(robot: ServedRobot, params: Params) -> ServedGoal:
    opening = params.optional_number("opening")
    position = params.optional_number("position")
    speed = params.optional_number("speed")
    effort = params.optional_number("effort")
    params.finish()
    return robot.gripper.move(
        opening=opening, position=position, speed=speed, effort=effort
    )


CALLS: Final[dict[str, Callable[[ServedRobot, Params], Json]]] = {
    "state": _state,
    "summary": _summary,
    "controllers.list": _controllers_list,
    "controllers.load": _controllers_load,
    "controllers.unload": _controllers_unload,
    "controllers.switch": _controllers_switch,
    "controller.query_state": _query_state,
    "sim.pause": _pause,
    "sim.resume": _resume,
    "sim.step": _step,
    "sim.reset": _reset,
    "sim.estop": _estop,
}
"""Methods that are answered at once."""

GOALS: Final[dict[str, Callable[[ServedRobot, Params], ServedGoal]]] = {
    "controller.follow": _follow,
    "gripper.move": _grip,
}
"""Methods that start a goal; the answer is ``{"goal": number}``."""
