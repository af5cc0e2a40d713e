"""Robots of tool0 for LeRobot's own programs: ``--robot.type=tool0``.

``lerobot-record``, ``lerobot-rollout`` and LeRobot's asynchronous client drive a
bring-up with them, simulated or real; LeRobot finds the
package by its name.
"""

from lerobot_robot_tool0.config import Tool0LeaderConfig, Tool0RobotConfig
from lerobot_robot_tool0.leader import Tool0Leader
from lerobot_robot_tool0.robot import Tool0Robot

__all__ = ["Tool0Leader", "Tool0LeaderConfig", "Tool0Robot", "Tool0RobotConfig"]
