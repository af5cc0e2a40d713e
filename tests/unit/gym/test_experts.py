"""Experts solve their tasks, with any action, arm and gripper, from random starts."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

import tool0.gym
from tool0.errors import Tool0Error
from tool0.gym.tasks import TASKS

pytestmark = pytest.mark.slow

N = 8


def solved(task: str, n: int = N, **options: Any) -> float:
    """Return the part of random starts that the expert solves."""
    env = gymnasium.make_vec(
        f"tool0/{task}-v0",
        num_envs=n,
        autoreset_mode="Disabled",
        terminate_on_success=False,
        **options,
    )
    act = tool0.gym.expert(env)
    observed, _ = env.reset(seed=0)
    done = np.zeros(n, dtype=bool)
    for _ in range(env.spec.max_episode_steps - 1):
        observed, _, _, _, info = env.step(act(observed))
        done |= info["is_success"]
        if done.all():
            break
    env.close()
    return float(done.mean())


@pytest.mark.parametrize("task", TASKS)
def test_it_solves_nearly_every_start(task: str) -> None:
    assert solved(task) >= 0.95


@pytest.mark.parametrize(
    ("task", "options"),
    [
        ("Lift", {"arm": "ur3e", "gripper": "hande", "action": "joint"}),
        ("Push", {"arm": "ur20", "gripper": "2f140", "action": "pose"}),
        ("Lift", {"randomise": True, "observation": "goal", "control_rate": 25.0}),
    ],
)
def test_it_fits_other_robots_and_actions(task: str, options: dict[str, Any]) -> None:
    assert solved(task, 4, **options) == 1.0


def test_a_still_arm_solves_nothing() -> None:
    env = gymnasium.make_vec("tool0/Lift-v0", num_envs=4)
    env.reset(seed=0)
    for _ in range(10):
        *_, info = env.step(np.zeros(env.action_space.shape, np.float32))
    env.close()
    assert not info["is_success"].any()


def test_an_action_is_in_the_space_of_either_environment() -> None:
    env = gymnasium.make("tool0/Stack-v0")
    observed, _ = env.reset(seed=0)
    assert tool0.gym.expert(env)(observed) in env.action_space
    env.close()
    many = gymnasium.make_vec("tool0/Stack-v0", num_envs=2)
    observed, _ = many.reset(seed=0)
    assert tool0.gym.expert(many)(observed) in many.action_space
    many.close()


def test_another_environment_has_none() -> None:
    with pytest.raises(Tool0Error, match="there is no expert for"):
        tool0.gym.expert(gymnasium.make("CartPole-v1"))
