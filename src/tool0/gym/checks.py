"""Checks the functions of a user's task once, before it is first used."""

from __future__ import annotations

from typing import Any

import numpy as np

from tool0.description.scene import Scene, SceneObject
from tool0.errors import ConfigError, did_you_mean
from tool0.gym.task import Start, State, Task


def check_objects(task: Task, scene: Scene) -> list[SceneObject]:
    """Return a task's objects from its scene.

    Raises:
        ConfigError: If the scene lacks an object.
    """
    by_name = {item.name: item for item in scene.objects}
    for name in task.objects:
        if name not in by_name:
            raise ConfigError(
                f"task {type(task).__name__}: there is no object '{name}' in its scene"
                f"{did_you_mean(name, by_name)}"
            )
    return [by_name[name] for name in task.objects]


def check_start(task: Task, start: object) -> Start:
    """Return the start that a task drew.

    Raises:
        ConfigError: If ``start`` is not a valid start of this task.
    """
    if not isinstance(start, Start):
        raise _wrong(task, "draw", f"a {type(start).__name__}", "a tool0.gym.Start")
    if start.is_held and (task.hold is None or not task.objects):
        raise _wrong(
            task, "draw: is_held", "True", "False, or the task needs a hold and objects"
        )
    k = len(task.objects)
    _check_array(task, "draw: places", start.places, (k, 3))
    _check_array(task, "draw: yaws", start.yaws, (k,))
    _check_array(task, "draw: goal", start.goal, (np.size(start.goal),))
    return start


def check_functions(task: Task, state: State) -> None:
    """Check the shapes of the arrays that the task's functions return for a state.

    Raises:
        ConfigError: If a shape is wrong.  The message contains the function and the
            correct shape.
    """
    n, g = len(state.goal), len(task.goal_names)
    achieved, desired = task.achieved(state), task.desired(state)
    _check_array(task, "achieved", achieved, (n, g))
    _check_array(task, "desired", desired, (n, g))
    success = task.is_success(achieved, desired)
    _check_array(task, "is_success", success, (n,), np.bool_)
    _check_array(task, "distance", task.distance(achieved, desired), (n,))
    _check_array(task, "progress", task.progress(state), (n,))
    _check_array(task, "reward", task.reward(state, success), (n,))
    for name, values in task.observe(state).items():
        given = np.shape(values)
        if len(given) not in {1, 2} or given[0] != n:
            raise _wrong(
                task, f"observe: {name}", f"shape {given}", f"({n},) or ({n}, m)"
            )


def _check_array(
    task: Task,
    what: str,
    values: Any,
    shape: tuple[int, ...],
    dtype: type[np.generic] | None = None,
) -> None:
    if np.shape(values) != shape:
        raise _wrong(task, what, f"shape {np.shape(values)}", f"shape {shape}")
    found = np.asarray(values).dtype
    if dtype is not None and found != dtype:
        raise _wrong(task, what, f"{found}", "booleans")


def _wrong(task: Task, what: str, found: str, right: str) -> ConfigError:
    return ConfigError(
        f"task {type(task).__name__}: {what} is {found}; it must be {right}"
    )
