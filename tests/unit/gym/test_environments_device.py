"""Environments on a device of MuJoCo Warp, beside those of the CPU."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from batch_rig import device_under_test, needs_warp
from numpy.typing import NDArray

import tool0
import tool0.gym

TOLERANCE = 1e-4
"""Of observations [m, rad, rad/s], while nothing touches a cube."""


@pytest.fixture(scope="module")
def device() -> str:
    return device_under_test()


def made(task: str, n: int, device: str, **options: Any) -> Any:
    return gymnasium.make_vec(f"tool0/{task}-v0", num_envs=n, device=device, **options)


@pytest.mark.parametrize("make", [gymnasium.make, gymnasium.make_vec])
def test_an_unknown_device_is_refused(make: Any) -> None:
    with pytest.raises(tool0.ConfigError, match="unknown device 'gpu'; valid: 'cpu'"):
        make("tool0/Reach-v0", device="gpu")


@needs_warp
def test_threads_are_those_of_the_cpu() -> None:
    with pytest.raises(tool0.ConfigError, match="threads are those of device='cpu'"):
        made("Reach", 2, "warp:cpu", threads=2)


@pytest.mark.parametrize(
    ("task", "options"),
    [("Reach", {}), ("Lift", {}), ("Lift", {"randomise": True})],
)
def test_experts_solve_tasks_as_on_the_cpu(
    device: str, task: str, options: dict[str, Any]
) -> None:
    counts = [actions_until_solved(task, each, options) for each in ("cpu", device)]
    assert all(count is not None for count in counts[1])
    assert np.abs(np.subtract(*counts)).max() <= 1  # a cube's last millimetre


def actions_until_solved(
    task: str, device: str, options: dict[str, Any]
) -> NDArray[np.int64]:
    n = 2
    env = made(task, n, device, terminate_on_success=False, **options)
    act = tool0.gym.expert(env)
    observed, _ = env.reset(seed=0)
    solved = np.zeros(n, dtype=bool)
    counts = np.zeros(n, dtype=np.int64)
    while not solved.all():
        observed, _, _, truncated, info = env.step(act(observed))
        assert not truncated.any()
        solved |= info["is_success"]
        counts += ~solved
    env.close()
    return counts


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_episodes_begin_again_as_on_the_cpu(device: str, mode: str) -> None:
    options: dict[str, Any] = {
        "max_episode_steps": 2,
        "autoreset_mode": mode,
        "randomise": True,
        "action": "joint",
    }
    host, other = made("Lift", 3, "cpu", **options), made("Lift", 3, device, **options)
    rng = np.random.default_rng(1)
    n_ended = 0
    for env in (host, other):
        env.reset(seed=[4, 5, 6])
    for k in range(4):
        if mode == "Disabled" and k == 2:
            mask = {"reset_mask": np.array([True, False, True])}
            for env in (host, other):
                env.reset(options=mask)
                env.reset(options={"reset_mask": ~mask["reset_mask"]})
        action = rng.uniform(-0.3, 0.3, host.action_space.shape)
        action[:, -1] = [-1.0, 1.0, 0.0]
        mine, its = other.step(action), host.step(action)
        np.testing.assert_allclose(mine[0], its[0], atol=TOLERANCE)
        np.testing.assert_allclose(mine[1], its[1], atol=TOLERANCE)
        np.testing.assert_array_equal(mine[2], its[2])
        np.testing.assert_array_equal(mine[3], its[3])
        n_ended += int(mine[3].sum())
    assert n_ended >= 3
    host.close()
    other.close()


def test_a_copy_that_diverges_is_truncated_and_begins_again(device: str) -> None:
    env = made("Reach", 2, device)
    env.reset(seed=0)
    still = np.zeros(env.action_space.shape)
    worlds = env.unwrapped.copies.batch._copies._worlds
    velocity = worlds.velocity.numpy()
    velocity[1, 0] = np.nan
    worlds.velocity.assign(velocity)
    observed, _, _, truncated, info = env.step(still)
    assert truncated.tolist() == info["diverged"].tolist() == [False, True]
    assert np.isfinite(observed).all()
    *_, truncated, info = env.step(still)
    assert not info["diverged"].any()
    env.close()


def test_a_single_environment_is_one_of_the_vector(device: str) -> None:
    one = gymnasium.make("tool0/Reach-v0", device=device)
    many = made("Reach", 2, device)
    mine, _ = one.reset(seed=1)
    its, _ = many.reset(seed=0)
    np.testing.assert_allclose(mine, its[1], atol=1e-6)
    action = np.array([0.5, -0.5, 0.2, 0.1, 1.0], np.float32)
    mine = one.step(action)[0]
    its = many.step(np.stack([action, action]))[0]
    np.testing.assert_allclose(mine, its[1], atol=1e-5)
    one.close()
    many.close()
