"""Registration of tool0's tasks and users' tasks with Gymnasium."""

from __future__ import annotations

from typing import Final

import gymnasium
from gymnasium.envs.registration import EnvSpec

from tool0.errors import ConfigError
from tool0.gym.options import read_options
from tool0.gym.task import Task
from tool0.gym.tasks import EPISODE_STEPS, TASKS, task_class

_SINGLE: Final = "tool0.gym.environments:TaskEnv"
_VECTOR: Final = "tool0.gym.environments:TaskVectorEnv"


def register(
    env_id: str, task: type[Task], *, max_episode_steps: int, **options: object
) -> None:
    """Register your own task for ``gymnasium.make`` and ``gymnasium.make_vec``.

    If a module registers its tasks when it is imported, the name of the module can
    precede the id, as in ``gymnasium.make("my_module:MyTask-v0")``.

    Args:
        env_id: Id of the environment, such as ``MyTask-v0`` or ``my_lab/MyTask-v0``.
        task: Class of the task, which is called with a ``Workspace``.
        max_episode_steps: Time limit of an episode, in actions.
        options: Defaults of the environment's options.

    Raises:
        ConfigError: If the class is not a task, or an option is wrong.
    """
    if not (isinstance(task, type) and issubclass(task, Task)):
        raise ConfigError(f"{task!r:.80} is no subclass of tool0.gym.Task")
    if not (isinstance(max_episode_steps, int) and max_episode_steps > 0):
        raise ConfigError(
            f"max_episode_steps must be a whole number above 0, got {max_episode_steps}"
        )
    read_options(options)
    _register(env_id, task, max_episode_steps, options)


def register_tasks() -> None:
    """Register the tasks of tool0."""
    for name in TASKS:
        _register(f"tool0/{name}-v0", name, EPISODE_STEPS[name], {})


def task_of(spec: EnvSpec) -> type[Task] | None:
    """Return the task of an environment; None if tool0 does not define it."""
    if spec.vector_entry_point != _VECTOR:
        return None
    return task_class(spec.kwargs["task"])


def _register(
    env_id: str,
    task: str | type[Task],
    max_episode_steps: int,
    options: dict[str, object],
) -> None:
    gymnasium.register(
        env_id,
        entry_point=_SINGLE,
        vector_entry_point=_VECTOR,
        max_episode_steps=max_episode_steps,
        kwargs={"task": task, **options},
    )
