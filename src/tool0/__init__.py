"""A UR arm with a Robotiq gripper in simulation, driven by real controllers.

Importing this package starts nothing and imports no simulator: the names below are
loaded when they are first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tool0.api.bringup import bringup
    from tool0.api.connect import connect
    from tool0.api.robot import Robot
    from tool0.control.goal import GoalResult, GoalStatus, GripperResult
    from tool0.control.trajectory import TrajectoryPoint
    from tool0.description.config import DescriptionConfig
    from tool0.errors import GoalRejectedError, Tool0Error
    from tool0.kinematics.inverse import Branch
    from tool0.runtime.config import ControlConfig, SimulationConfig

__all__ = [
    "Branch",
    "ControlConfig",
    "DescriptionConfig",
    "GoalRejectedError",
    "GoalResult",
    "GoalStatus",
    "GripperResult",
    "Robot",
    "SimulationConfig",
    "Tool0Error",
    "TrajectoryPoint",
    "bringup",
    "connect",
]

_HOMES = {
    "Branch": "tool0.kinematics.inverse",
    "ControlConfig": "tool0.runtime.config",
    "DescriptionConfig": "tool0.description.config",
    "GoalRejectedError": "tool0.errors",
    "GoalResult": "tool0.control.goal",
    "GoalStatus": "tool0.control.goal",
    "GripperResult": "tool0.control.goal",
    "Robot": "tool0.api.robot",
    "SimulationConfig": "tool0.runtime.config",
    "Tool0Error": "tool0.errors",
    "TrajectoryPoint": "tool0.control.trajectory",
    "bringup": "tool0.api.bringup",
    "connect": "tool0.api.connect",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'tool0' has no attribute '{name}'")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
