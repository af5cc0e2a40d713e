"""Tasks for Gymnasium, registered when this module is imported.

Use them with ``gymnasium.make`` and ``gymnasium.make_vec``::

    import gymnasium, tool0.gym

    env = gymnasium.make("tool0/Lift-v0", arm="ur5e", gripper="hande")
    many = gymnasium.make_vec("tool0/Lift-v0", num_envs=64)
"""

from __future__ import annotations

from tool0.errors import GymUnavailableError

try:
    import gymnasium  # noqa: F401  # checks that it is installed
except ImportError:
    raise GymUnavailableError(
        "tool0.gym needs Gymnasium, which is not installed; run pip install '.[gym]'"
    ) from None

from tool0.gym.expert import Expert, expert
from tool0.gym.hold import Hold
from tool0.gym.options import Randomisation
from tool0.gym.registration import register, register_tasks
from tool0.gym.task import ArmState, Start, State, Target, Task
from tool0.gym.ways import Grasp, carried, grasp, lift, place, push, reach
from tool0.gym.workspace import Workspace

__all__ = [
    "ArmState",
    "Expert",
    "Grasp",
    "Hold",
    "Randomisation",
    "Start",
    "State",
    "Target",
    "Task",
    "Workspace",
    "carried",
    "expert",
    "grasp",
    "lift",
    "place",
    "push",
    "reach",
    "register",
]

register_tasks()
