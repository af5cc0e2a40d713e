"""Scripted experts, which use the full state of the simulation to solve tasks.

``Task.expert`` returns the next target of the tool and gripper.  This module converts
the target of an expert to an action.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from tool0.description.transform_arrays import Frames, from_rotation_vectors
from tool0.errors import ConfigError
from tool0.gym.arms import ArmCopies
from tool0.gym.copies import Copies
from tool0.gym.environments import TaskEnv, TaskVectorEnv
from tool0.gym.task import Target, Task
from tool0.gym.tool import chord_vectors, downward
from tool0.kinematics.chain import Array
from tool0.kinematics.geometry import wrapped

GAIN = 0.6
"""Fraction of the remaining distance to a target that one action covers."""


@final
class Expert:
    """Returns an action for each observation of one environment."""

    def __init__(self, copies: Copies, *, single: bool) -> None:
        self._copies = copies
        self._single = single

    def __call__(self, observation: object = None) -> NDArray[np.float32]:
        """Return the action, shape (m,), or the actions of all copies, shape (n, m).

        ``observation`` is ignored.  The expert reads the state of the simulation, so it
        also works with image observations.
        """
        copies = self._copies
        commanded = {
            arm.space.arm: arm.space.tool.pose(arm.target) for arm in copies.arms
        }
        targets = copies.task.experts(copies.state, commanded)
        if targets.keys() != commanded.keys():
            raise ConfigError(
                f"task {type(copies.task).__name__}: experts is for the arms "
                f"{', '.join(targets)}; it must be for {', '.join(commanded)}"
            )
        actions = np.concatenate(
            [
                _action(arm, targets[name], commanded[name])
                for name, arm in zip(commanded, copies.arms, strict=True)
            ],
            axis=1,
        )
        found: NDArray[np.float32] = actions.astype(np.float32)
        return found[0] if self._single else found


def _action(arm: ArmCopies, target: Target, pose: Frames) -> Array:
    """Return actions, (n, m), that move an arm's TCP from ``pose`` to ``target``."""
    widest = arm.space.gripper.max_opening
    opening = np.clip(2.0 * target.opening / widest - 1.0, -1.0, 1.0)
    return np.concatenate([_motion(arm, target, pose), opening[:, None]], axis=1)


def _motion(arm: ArmCopies, target: Target, pose: Frames) -> Array:
    """Return the actions without the gripper's action, shape (n, m - 1)."""
    actions, q = arm.actions, arm.target
    way = GAIN * (target.position - pose.position)
    if actions.mode == "cartesian":
        turn = GAIN * wrapped(target.yaw - pose.yaw)[:, None]
    else:
        turn = GAIN * chord_vectors(pose.rotation, downward(target.yaw))
    linear = _within(way / actions.linear, target.speed)
    angular = _within(turn / actions.turn, np.ones(len(turn)))
    if actions.mode != "joint":
        return np.concatenate([linear, angular], axis=1)
    aim = Frames(
        pose.position + linear * actions.linear,
        from_rotation_vectors(angular * actions.turn) @ pose.rotation,
    )
    return _within((actions.approach(q, aim) - q) / actions.joint, np.ones(len(q)))


def expert(env: Any) -> Expert:  # Env or VectorEnv, in any wrappers
    """Return an expert for one of tool0's environments.

    Raises:
        ConfigError: If the environment is not from tool0, or its task has no expert.
    """
    inner = getattr(env, "unwrapped", env)
    if not isinstance(inner, TaskEnv | TaskVectorEnv):
        raise ConfigError(
            f"there is no expert for {env!r:.80}; make a tool0/… environment"
        )
    task = type(inner.copies.task)
    if task.expert is Task.expert and task.experts is Task.experts:
        method = "experts" if task.arms else "expert"
        raise ConfigError(
            f"the task {task.__name__} has no expert: give it a method `{method}`"
        )
    return Expert(inner.copies, single=isinstance(inner, TaskEnv))


def _within(action: Array, largest: Array) -> Array:
    """Return actions (n, m), scaled down to magnitudes of at most ``largest``, (n,)."""
    excess = np.maximum(1.0, np.abs(action).max(axis=1) / largest)
    return np.asarray(action / excess[:, None])
