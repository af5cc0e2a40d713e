"""A run in plain values, for ``--summary json`` and for scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tool0.runtime.loop import Loop

if TYPE_CHECKING:
    from tool0.runtime.robot import Robot


def summarize(robot: Robot, loop: Loop, *, wall_time: float) -> dict[str, object]:
    """Return the run so far.

    Args:
        robot: Whose run.
        loop: What ran it.
        wall_time: How long it took [s].
    """
    snapshot = robot.snapshot
    sim_time = loop.steps * loop.control_period
    return {
        "engine": robot.engine.name,
        "sim_time": sim_time,
        "wall_time": wall_time,
        "real_time_factor": sim_time / wall_time,
        "steps": loop.steps,
        "overruns": loop.overruns,
        "controllers": [
            {
                "name": status.name,
                "type": status.type,
                "state": status.state,
                "claimed": [joint for _, joints in status.claimed for joint in joints],
            }
            for status in snapshot.controllers
        ],
        "joints": {
            name: {"position": position, "velocity": velocity, "effort": effort}
            for name, position, velocity, effort in zip(
                snapshot.joint_names,
                snapshot.position,
                snapshot.velocity,
                snapshot.effort,
                strict=True,
            )
        },
        "max_drift": loop.max_drift,
        "warnings": [
            {
                "file": str(item.location.file or "<string>"),
                "line": item.location.line,
                "key": item.key,
                "message": item.text,
            }
            for item in robot.warnings
        ],
    }
