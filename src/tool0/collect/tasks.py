"""Tasks by name: built-in tasks, or environments that a module or file registers.

Workers find an environment by these names.  Neither code nor pickled objects are sent.
"""

from __future__ import annotations

import re
import warnings
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Final

from tool0.collect.user_files import cannot_load, is_file, located_file, run_file
from tool0.errors import ConfigError, did_you_mean

if TYPE_CHECKING:
    from gymnasium.envs.registration import EnvSpec

_VERSION: Final = re.compile(r"-v\d+$")


def located_task(task: str) -> tuple[str, str | None]:
    """Return the full name of a task, and the SHA-256 of its file, if it has one.

    Raises:
        ConfigError: If there is no such task.
    """
    digest = None
    if is_file(task):
        task, digest = located_file(task, "task")
    environment_spec(task, digest)
    return task, digest


def environment_spec(task: str, digest: str | None) -> EnvSpec:
    """Return Gymnasium's specification of a task.

    Args:
        task: Name of a built-in task, the id of an environment, ``module:id``, or
            ``file.py:id``, in the form that ``located_task`` returns.
        digest: SHA-256 of the file; None if no file defines the task.

    Raises:
        ConfigError: If there is no such task.
    """
    import gymnasium

    if not _VERSION.search(task):
        from tool0.gym.tasks import TASKS

        if task not in TASKS:
            raise ConfigError(f"unknown task '{task}'{did_you_mean(task, list(TASKS))}")
        return gymnasium.spec(f"tool0/{task}-v0")
    place, _, name = task.rpartition(":")
    try:
        if digest is not None:
            _run_file(task, digest)
        elif place:
            import_module(place)
        return gymnasium.spec(name)
    except (gymnasium.error.Error, ImportError) as error:
        raise ConfigError(f"task '{task}': {error}") from None


@cache
def _run_file(task: str, digest: str) -> None:
    """Run the file that registers a task unless it has already been run."""
    try:
        with warnings.catch_warnings():
            # the calling program may already have registered the environment
            warnings.filterwarnings("ignore", ".*Overriding environment")
            run_file(task, digest, "task")
    except ConfigError:
        raise
    except Exception as error:  # raised by the user's code
        raise cannot_load(task, "task", error) from error


def default_instruction(task: str, digest: str | None) -> str:
    """Return the instruction of a task, or its id if it has no instruction."""
    from tool0.gym.registration import task_of

    found = task_of(environment_spec(task, digest))
    name = task if digest is None else task.rpartition(":")[2]
    return (found and found.instruction) or name
