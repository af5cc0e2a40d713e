"""Tasks for Gymnasium: importing this module registers them.

For ``gymnasium.make`` and ``gymnasium.make_vec``::

    import gymnasium, tool0.gym

    env = gymnasium.make("tool0/Lift-v0", arm="ur5e", gripper="hande")
    many = gymnasium.make_vec("tool0/Lift-v0", num_envs=64)
"""

from __future__ import annotations

from tool0.errors import GymUnavailableError

try:
    import gymnasium
except ImportError:
    raise GymUnavailableError(
        "tool0.gym needs Gymnasium, which is not installed; run pip install '.[gym]'"
    ) from None

from tool0.gym.expert import Expert, expert
from tool0.gym.options import Randomisation
from tool0.gym.tasks import EPISODE_STEPS, TASKS

__all__ = ["Expert", "Randomisation", "expert"]

for _task in TASKS:
    gymnasium.register(
        f"tool0/{_task}-v0",
        entry_point="tool0.gym.environments:TaskEnv",
        vector_entry_point="tool0.gym.environments:TaskVectorEnv",
        max_episode_steps=EPISODE_STEPS[_task],
        kwargs={"task": _task},
    )
