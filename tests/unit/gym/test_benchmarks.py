"""Insertion, assembly, a drawer and clutter: what they are, beside their experts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from raises_naming import raises_naming

import tool0.gym
from tool0.collect import collect
from tool0.description.transform_arrays import from_quats
from tool0.errors import ConfigError
from tool0.gym import Hold
from tool0.gym.benchmarks import nut_on_peg, open_drawer, peg_insertion, pick_clutter

pytestmark = pytest.mark.slow

BENCHMARKS = ("PegInsertion", "NutOnPeg", "OpenDrawer", "PickClutter")
WEIGHT = 9.80665
PRESS = 8.0
"""Force of a peg on the rim [N]."""


def many(task: str, n: int, **options: Any) -> Any:
    return gymnasium.make_vec(
        f"tool0/{task}-v0",
        num_envs=n,
        autoreset_mode="Disabled",
        terminate_on_success=False,
        **options,
    )


def run(envs: Any, steps: int) -> np.ndarray:
    """Let the expert act; return which copies succeeded."""
    expert = tool0.gym.expert(envs)
    done = np.zeros(envs.num_envs, dtype=bool)
    for _ in range(steps):
        *_, info = envs.step(expert())
        done |= info["is_success"]
        if done.all():
            break
    return done


@pytest.mark.parametrize("task", BENCHMARKS)
def test_experts_work_with_another_arm_and_gripper(task: str) -> None:
    envs = many(task, 4, arm="ur5e", gripper="hande", randomise=True)
    envs.reset(seed=3)
    assert run(envs, 150).all()
    envs.close()


def test_an_episode_is_collected(tmp_path: Path) -> None:
    manifest = collect("PegInsertion", 2, tmp_path / "set", workers=1)
    assert (manifest.n_episodes, manifest.n_succeeded) == (2, 2)


# ---- a peg -------------------------------------------------------------------------


@pytest.mark.parametrize("randomise", [False, True])
def test_an_episode_begins_with_the_peg_in_the_gripper(*, randomise: bool) -> None:
    envs = many("PegInsertion", 3, randomise=randomise, observation="dict")
    for seed in (1, 2):
        seen, _ = envs.reset(seed=seed)
        copies = envs.unwrapped.copies
        assert (copies.batch.pad_forces() > 20.0).all()
        assert np.abs(seen["opening"] - peg_insertion.PEG_WIDTH).max() < 0.001
        weight = np.linalg.norm(seen["wrench"][:, :3], axis=1)
        own = WEIGHT * peg_insertion.PEG_MASS
        assert (weight == pytest.approx(own, rel=0.1)) is not randomise
        assert ((0.4 * own < weight) & (weight < 2.2 * own)).all()
    # The socket is fixed, and elsewhere in each episode.
    sockets = copies.state.object_position[:, 1]
    assert np.ptp(sockets, axis=0)[:2].min() > 0.01
    again, _ = envs.reset(seed=2)
    for name, values in seen.items():
        np.testing.assert_array_equal(values, again[name])
    envs.close()


def test_the_held_start_does_not_depend_on_what_was_before() -> None:
    envs = many("PegInsertion", 2)
    first, _ = envs.reset(seed=5)
    for _ in range(5):
        envs.step(envs.action_space.sample())
    again, _ = envs.reset(seed=5)
    np.testing.assert_array_equal(first, again)
    envs.close()


def test_a_gripper_that_cannot_hold_the_object_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(peg_insertion.PegInsertion, "hold", Hold(0.05))
    envs = many("PegInsertion", 1)
    with raises_naming(ConfigError, "cannot hold 'peg'", "Task.hold.width is 0.05 m"):
        envs.reset(seed=1)
    envs.close()


def test_a_peg_beside_the_hole_is_stopped_by_the_rim() -> None:
    envs = many("PegInsertion", 2)
    envs.reset(seed=8)
    run(envs, 15)
    copies, top = envs.unwrapped.copies, peg_insertion.TABLE_TOP + peg_insertion.HEIGHT
    assert (copies.task.achieved(copies.state)[:, 2] > top).all()
    actions = np.zeros((2, 5), np.float32)
    actions[:, 4] = -1.0
    actions[:, 0] = 0.25
    envs.step(actions)
    actions[:, 0] = 0.0
    for _ in range(60):
        is_free = np.abs(copies.state.wrench[:, 2]) < PRESS
        actions[:, 2] = np.where(is_free, -0.05, 0.0)
        *_, info = envs.step(actions)
    end = copies.task.achieved(copies.state)[:, 2]
    assert (np.abs(end - top) < 0.0005).all()
    assert not info["is_success"].any()
    assert (np.abs(copies.state.wrench[:, 2]) >= PRESS).all()
    envs.close()


# ---- a nut -------------------------------------------------------------------------


def test_a_nut_that_is_held_is_not_there_yet() -> None:
    envs = many("NutOnPeg", 2)
    envs.reset(seed=4)
    task = envs.unwrapped.copies.task
    done = run(envs, 120)
    state = envs.unwrapped.copies.state
    assert done.all()
    goal = task.desired(state)
    lifted, aside = 2.0 * nut_on_peg.LEVEL, 2.0 * nut_on_peg.AROUND
    for column, change in ((3, -1.0), (2, lifted), (0, aside)):
        achieved = goal.copy()
        achieved[:, column] += change
        assert not task.is_success(achieved, goal).any()
    # The peg is in the hole of the nut: none can pass through the other.
    offset = state.object_position[:, 0, :2] - state.object_position[:, 1, :2]
    room = nut_on_peg.INNER - nut_on_peg.PEG_WIDTH
    assert (np.abs(offset) < room).all()
    envs.close()


# ---- a drawer ----------------------------------------------------------------------


def test_a_drawer_slides_out_straight() -> None:
    envs = many("OpenDrawer", 3)
    envs.reset(seed=6)
    copies = envs.unwrapped.copies
    assert np.abs(copies.task.achieved(copies.state)).max() < 1e-6
    assert run(envs, 80).all()
    state = copies.state
    R = from_quats(state.object_quat[:, 1])
    away = state.object_position[:, 0] - state.object_position[:, 1]
    x, y, _ = np.einsum("nji,nj->in", R, away)
    assert (x >= open_drawer.PULLED).all()
    assert (np.abs(y) < 2.0 * open_drawer.PLAY).all()
    envs.close()


def test_a_drawer_that_nobody_pulls_stays() -> None:
    envs = many("OpenDrawer", 2)
    envs.reset(seed=7)
    rest = np.zeros(envs.action_space.shape, np.float32)
    for _ in range(20):
        *_, info = envs.step(rest)
    copies = envs.unwrapped.copies
    assert np.abs(copies.task.achieved(copies.state)).max() < 0.0005
    assert not info["is_success"].any()
    envs.close()


# ---- clutter -----------------------------------------------------------------------


def test_things_lie_close_to_the_target_and_apart() -> None:
    envs = many("PickClutter", 20)
    envs.reset(seed=0)
    copies = envs.unwrapped.copies
    places = copies.state.object_position[..., :2]
    radii = [copies.task._edge / math.sqrt(2.0), *copies.task._radii]
    away = np.linalg.norm(places[:, 1:] - places[:, :1], axis=2)
    assert away.max() < 0.15
    assert (np.sort(away, axis=1)[:, 2] < 0.08).all()
    for i in range(len(radii)):
        for k in range(i):
            gap = np.linalg.norm(places[:, i] - places[:, k], axis=1)
            assert (gap - radii[i] - radii[k] > 0.5 * pick_clutter.GAP).all()
    before = copies.state.object_position
    rest = np.zeros(envs.action_space.shape, np.float32)
    for _ in range(10):
        envs.step(rest)
    # Nothing is pushed out of anything else.
    assert np.abs(copies.state.object_position - before).max() < 0.0005
    envs.close()


def test_only_the_target_counts() -> None:
    envs = many("PickClutter", 1)
    envs.reset(seed=2)
    copies = envs.unwrapped.copies
    batch, k = copies.batch, copies.batch.object_names.index("brick")
    copies.batch.place("brick", batch.object_position[:, k] + [0.0, 0.0, 0.3])
    *_, info = envs.step(np.zeros(envs.action_space.shape, np.float32))
    assert not info["is_success"].any()
    envs.close()
