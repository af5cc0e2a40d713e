"""The built-in tasks by name."""

from __future__ import annotations

from tool0.errors import ConfigError, did_you_mean
from tool0.gym.benchmarks.handover import Handover
from tool0.gym.benchmarks.nut_on_peg import NutOnPeg
from tool0.gym.benchmarks.open_drawer import OpenDrawer
from tool0.gym.benchmarks.peg_insertion import PegInsertion
from tool0.gym.benchmarks.pick_clutter import PickClutter
from tool0.gym.cubes import Lift, PickPlace, Push, Reach, Stack
from tool0.gym.task import Task

TASKS: dict[str, type[Task]] = {
    "Reach": Reach,
    "Lift": Lift,
    "PickPlace": PickPlace,
    "Stack": Stack,
    "Push": Push,
    "PegInsertion": PegInsertion,
    "NutOnPeg": NutOnPeg,
    "OpenDrawer": OpenDrawer,
    "PickClutter": PickClutter,
    "Handover": Handover,
}
EPISODE_STEPS = {
    "Reach": 100,
    "Lift": 200,
    "PickPlace": 300,
    "Stack": 300,
    "Push": 300,
    "PegInsertion": 300,
    "NutOnPeg": 300,
    "OpenDrawer": 200,
    "PickClutter": 200,
    "Handover": 300,
}
"""Time limit of each task, in actions."""


def task_class(task: str | type[Task]) -> type[Task]:
    """Return the class of a task, given its name or the class.

    Raises:
        ConfigError: If there is no such task.
    """
    if isinstance(task, type):
        return task
    if task not in TASKS:
        raise ConfigError(f"unknown task '{task}'{did_you_mean(task, TASKS)}")
    return TASKS[task]
