"""The list of what is looked at, in the order in which it is told."""

from __future__ import annotations

from typing import Final

NEEDED: Final = ("python", "mujoco")
"""Without which ``tool0 bringup`` does not run."""
PROBES: Final = {
    "machine": "tool0.installation.doctor.basics",
    "python": "tool0.installation.doctor.basics",
    "mujoco": "tool0.installation.doctor.basics",
    "panel": "tool0.installation.doctor.screen",
    "browser": "tool0.installation.doctor.screen",
    "gpu": "tool0.installation.doctor.screen",
    "cameras": "tool0.installation.doctor.screen",
    "gazebo": "tool0.installation.doctor.simulators",
    "ros1": "tool0.installation.doctor.ros",
    "ros2": "tool0.installation.doctor.ros",
    "workspace": "tool0.installation.doctor.workspace",
}
"""Function → the module that has it."""
