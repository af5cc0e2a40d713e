"""Robots of tool0 for LeRobot's own programs: ``--robot.type=tool0``.

``lerobot-record``, ``lerobot-rollout`` and LeRobot's asynchronous client drive a
bring-up with them, simulated or real.  ``--teleop.type`` is another bring-up
(``tool0_leader``), a gamepad or a SpaceMouse.  LeRobot finds the package by its name.
"""

from lerobot_robot_tool0.config import (
    Tool0GamepadConfig,
    Tool0LeaderConfig,
    Tool0RobotConfig,
    Tool0SpaceMouseConfig,
)
from lerobot_robot_tool0.leader import Tool0Leader
from lerobot_robot_tool0.robot import Tool0Robot
from lerobot_robot_tool0.tool_teleoperator import Tool0Gamepad, Tool0SpaceMouse

__all__ = [
    "Tool0Gamepad",
    "Tool0GamepadConfig",
    "Tool0Leader",
    "Tool0LeaderConfig",
    "Tool0Robot",
    "Tool0RobotConfig",
    "Tool0SpaceMouse",
    "Tool0SpaceMouseConfig",
]
