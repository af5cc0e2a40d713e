"""The list of what is looked at, in the order in which it is told."""

from __future__ import annotations

from typing import Final

NEEDED: Final = ("python", "mujoco")
"""Without which ``tool0 bringup`` does not run."""
PROBES: Final = {
    "machine": "tool0.doctor.basics",
    "python": "tool0.doctor.basics",
    "mujoco": "tool0.doctor.basics",
    "panel": "tool0.doctor.screen",
    "browser": "tool0.doctor.screen",
    "gpu": "tool0.doctor.screen",
    "cameras": "tool0.doctor.screen",
    "gazebo": "tool0.doctor.simulators",
    "ros1": "tool0.doctor.ros",
    "ros2": "tool0.doctor.ros",
    "workspace": "tool0.doctor.workspace",
}
"""Function → the module that has it."""
