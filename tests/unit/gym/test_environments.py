"""What Gymnasium asks of an environment, and what ours promise beside it."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from promised import require_gl

import tool0.gym
from tool0.errors import Tool0Error
from tool0.gym.tasks import EPISODE_STEPS, TASKS

pytestmark = pytest.mark.slow

N = 5
SEED = 5
ACTIONS, OBSERVATIONS = ("joint", "cartesian", "pose"), ("state", "dict", "goal")
SQUARE = [
    (task, action, OBSERVATIONS[(i + k) % 3])
    for i, task in enumerate(TASKS)
    for k, action in enumerate(ACTIONS)
]
"""Every pair of two of the three, once: none knows of the other two."""


def make(task: str, **options: Any) -> Any:
    return gymnasium.make(f"tool0/{task}-v0", **options)


def make_vec(task: str, n: int = N, **options: Any) -> Any:
    return gymnasium.make_vec(f"tool0/{task}-v0", num_envs=n, **options)


@pytest.fixture
def lifts() -> Iterator[Any]:
    env = make_vec("Lift", 3, max_episode_steps=4)
    yield env
    env.close()


@pytest.mark.parametrize(("task", "action", "observation"), SQUARE)
def test_the_checker_has_no_complaint(task: str, action: str, observation: str) -> None:
    env = make(task, action=action, observation=observation).unwrapped
    check_env(env, skip_render_check=True)


def test_the_checker_accepts_images() -> None:
    require_gl()
    env = make(
        "Lift", observation="image", render_mode="rgb_array", image_size=(40, 30)
    )
    check_env(env.unwrapped, skip_close_check=True)
    observation, _ = env.reset(seed=0)
    assert observation["rgb"].shape == (30, 40, 3)
    assert observation["rgb"].std() > 1.0
    assert (env.render() == observation["rgb"]).all()
    env.close()


def test_several_cameras_and_depth() -> None:
    require_gl()
    options = {"observation": "image", "image_size": (40, 30), "depth": True}
    both = make_vec("Lift", 2, camera=("scene", "wrist"), **options)
    observation, _ = both.reset(seed=0)
    assert both.observation_space.contains(observation)
    assert observation["rgb_wrist"].shape == (2, 30, 40, 3)
    assert (observation["rgb_wrist"] != observation["rgb_scene"]).any()
    scene, wrist = (observation[f"depth_{name}"] for name in ("scene", "wrist"))
    assert scene.dtype == np.float32
    assert 0.1 < wrist[0, 15, 20] < scene[0, 15, 20] < 2.0
    both.close()
    one = make("Lift", camera="wrist", **options)
    same, _ = one.reset(seed=1)
    assert (same["rgb"] == observation["rgb_wrist"][1]).all()
    assert (same["depth"] == wrist[1]).all()
    one.close()


@pytest.mark.parametrize(("task", "action"), [(t, a) for t, a, _ in SQUARE[::2]])
def test_a_copy_is_the_single_environment_bit_for_bit(task: str, action: str) -> None:
    options = {"action": action, "randomise": True}
    many = make_vec(task, **options)
    rng = np.random.default_rng(SEED)
    observed, _ = many.reset(seed=SEED)
    steps = [(observed, None)]
    actions = rng.uniform(-1.0, 1.0, (6, *many.action_space.shape)).astype(np.float32)
    for each in actions:
        observed, reward, *_ = many.step(each)
        steps.append((observed, reward))
    many.close()
    for i in (0, N - 1):
        env = make(task, **options)
        observed, _ = env.reset(seed=SEED + i)
        np.testing.assert_array_equal(observed, steps[0][0][i])
        for k, each in enumerate(actions[:, i]):
            observed, reward, *_ = env.step(each)
            np.testing.assert_array_equal(observed, steps[k + 1][0][i])
            assert reward == steps[k + 1][1][i]
        env.close()


def test_episodes_go_on_from_a_seed_alike_in_any_number_of_copies() -> None:
    starts = []
    for n in (1, 3):
        env = make_vec("Stack", n, max_episode_steps=2, randomise=True)
        env.reset(seed=SEED)
        for _ in range(3):  # the third step starts the second episode
            observed, *_ = env.step(np.zeros(env.action_space.shape, np.float32))
        starts.append(observed[0])
        env.close()
    np.testing.assert_array_equal(*starts)


def test_a_deep_copy_goes_on_alike_and_apart() -> None:
    env = make("Lift", randomise=True)
    rng = np.random.default_rng(SEED)
    env.reset(seed=SEED)
    env.reset()  # of a generator that has gone on

    def act(each: Any) -> Any:
        return each.step(action)[:4]

    for _ in range(5):
        action = rng.uniform(-1.0, 1.0, 5).astype(np.float32)
        act(env)
    twin = copy.deepcopy(env)
    states = [each.unwrapped.copies.state for each in (env, twin)]
    measured = [[*arm, *s[1:]] for s in states for arm in s.arms.values()]
    for one, other in zip(*measured, strict=True):
        np.testing.assert_array_equal(one, other)
    for _ in range(5):
        action = rng.uniform(-1.0, 1.0, 5).astype(np.float32)
        first, second = act(env), act(twin)
        np.testing.assert_array_equal(first[0], second[0])
        assert first[1:] == second[1:]
    env.close()
    act(twin)  # which needs nothing of the other
    twin.close()


def test_copies_of_many_go_on_alike_whenever_they_were_reset() -> None:
    many = make_vec("Push", 3, max_episode_steps=4)
    rng = np.random.default_rng(SEED)
    many.reset(seed=SEED)
    actions = rng.uniform(-1.0, 1.0, (14, *many.action_space.shape)).astype(np.float32)
    for action in actions[:2]:
        many.step(action)
    many.reset(options={"reset_mask": np.array([False, True, False])})
    for action in actions[2:7]:
        many.step(action)
    twin = copy.deepcopy(many)
    for action in actions[7:]:
        for first, second in zip(
            many.step(action)[:4], twin.step(action)[:4], strict=True
        ):
            np.testing.assert_array_equal(first, second)
    many.close()
    twin.close()


def test_an_environment_can_be_copied_before_its_reset() -> None:
    env = make("Reach")
    twin = copy.deepcopy(env)
    observed = [each.reset(seed=SEED)[0] for each in (env, twin)]
    np.testing.assert_array_equal(*observed)
    env.close()
    twin.close()


def test_another_seed_is_another_episode() -> None:
    env = make("Lift")
    first, second, third = (env.reset(seed=seed)[0] for seed in (1, 2, 1))
    env.close()
    assert (first != second).any()
    np.testing.assert_array_equal(first, third)


def test_the_next_step_starts_the_next_episode(lifts: Any) -> None:
    rest = np.zeros(lifts.action_space.shape, np.float32)
    first, _ = lifts.reset(seed=0)
    for _ in range(4):
        _, reward, terminated, truncated, _ = lifts.step(rest)
    assert truncated.all()
    assert not terminated.any()
    start, reward, terminated, truncated, _ = lifts.step(rest)
    assert not (truncated | terminated).any()
    assert (reward == 0.0).all()
    joints = lifts.unwrapped.state_slices["joint_position"]
    cube = lifts.unwrapped.state_slices["cube_position"]
    np.testing.assert_array_equal(start[:, joints], first[:, joints])
    assert (start[:, cube] != first[:, cube]).any(axis=1).all()


def test_the_same_step_returns_the_last_observation_beside_the_first() -> None:
    ends = {}
    for mode in ("NextStep", "SameStep"):
        env = make_vec("Lift", 2, max_episode_steps=3, autoreset_mode=mode)
        env.reset(seed=0)
        rest = np.zeros(env.action_space.shape, np.float32)
        for _ in range(3):
            observed, _, _, truncated, infos = env.step(rest)
        assert truncated.all()
        ends[mode] = observed, infos
        if mode == "NextStep":
            ends["then"] = env.step(rest)[0], {}
        env.close()
    last = np.stack(ends["SameStep"][1]["final_obs"])
    np.testing.assert_array_equal(last, ends["NextStep"][0])
    np.testing.assert_array_equal(ends["SameStep"][0], ends["then"][0])
    assert not ends["SameStep"][1]["final_info"]["is_success"].any()


def test_without_autoreset_a_mask_says_what_to_reset() -> None:
    env = make_vec("Reach", 2, max_episode_steps=2, autoreset_mode="Disabled")
    env.reset(seed=0)
    rest = np.zeros(env.action_space.shape, np.float32)
    env.step(rest)
    env.step(rest)
    with pytest.raises(Tool0Error, match=r"copies \[0, 1\] have ended; reset them"):
        env.step(rest)
    with pytest.raises(Tool0Error, match="reset_mask must be booleans of shape"):
        env.reset(options={"reset_mask": [True]})
    env.reset(options={"reset_mask": np.array([True, False])})
    with pytest.raises(Tool0Error, match=r"copies \[1\] have ended"):
        env.step(rest)
    env.close()


def test_time_limits_are_those_of_the_registry() -> None:
    for task, steps in EPISODE_STEPS.items():
        assert gymnasium.spec(f"tool0/{task}-v0").max_episode_steps == steps
    env = make("Reach", max_episode_steps=2)
    env.reset(seed=0)
    rest = np.zeros(env.action_space.shape, np.float32)
    assert [env.step(rest)[3] for _ in range(2)] == [False, True]
    env.close()


@pytest.mark.parametrize("reward", ["dense", "sparse"])
@pytest.mark.parametrize("task", TASKS)
def test_rewards_of_goals_can_be_computed_again(task: str, reward: str) -> None:
    env = make_vec(task, 2, observation="goal", reward=reward)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(5):
        actions = rng.uniform(-1.0, 1.0, env.action_space.shape).astype(np.float32)
        observed, rewards, *_ = env.step(actions)
        achieved, desired = observed["achieved_goal"], observed["desired_goal"]
        again = env.unwrapped.compute_reward(achieved, desired, {})
        np.testing.assert_array_equal(again, rewards)
        assert ((rewards >= -1.0) & (rewards <= 0.0)).all()
    # A goal that is achieved: nothing is missing.
    best = env.unwrapped.compute_reward(desired, desired, {})
    np.testing.assert_array_equal(best, np.zeros(2))
    env.close()


@pytest.mark.parametrize("terminates", [True, False])
def test_success_ends_an_episode_or_does_not(terminates: bool) -> None:
    env = make("Reach", terminate_on_success=terminates, reward="sparse")
    act = tool0.gym.expert(env)
    observed, info = env.reset(seed=1)
    assert not info["is_success"]
    for _ in range(40):
        observed, reward, terminated, _, info = env.step(act(observed))
        assert reward == (0.0 if info["is_success"] else -1.0)
        assert terminated == (info["is_success"] and terminates)
        if info["is_success"]:
            break
    assert info["is_success"]
    env.close()


def test_what_is_randomised_differs_and_stays_in_its_range() -> None:
    ranges = tool0.gym.Randomisation(mass=(1.0, 3.0), friction=(0.5, 0.6))
    env = make_vec("Stack", 4, randomise=ranges)
    env.reset(seed=0)
    copies = env.unwrapped.copies
    objects = [
        item
        for core in copies.batch._cores
        for item in core.scene.objects
        if item.name in copies.task.objects
    ]
    for field, own, (low, high) in (
        ("mass", 0.1, ranges.mass),
        ("friction", 1.0, ranges.friction),
    ):
        values = {getattr(item, field) / own for item in objects}
        assert len(values) == 8
        assert low <= min(values) < max(values) <= high
    noise = copies.state.q - copies.workspace.start
    env.close()
    assert len(np.unique(noise)) == noise.size
    assert np.abs(noise).max() <= ranges.joint_noise


def test_a_copy_that_diverges_is_truncated_and_starts_again(
    lifts: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    rest = np.zeros(lifts.action_space.shape, np.float32)
    lifts.reset(seed=0)
    fails = property(lambda batch: np.array([False, True, False]))
    with monkeypatch.context() as patched:
        patched.setattr(tool0.Batch, "diverged", fails)
        observed, rewards, terminated, truncated, infos = lifts.step(rest)
    assert observed in lifts.observation_space
    assert infos["diverged"].tolist() == truncated.tolist() == [False, True, False]
    assert not terminated.any()
    assert rewards[1] == -1.0
    _, _, _, truncated, infos = lifts.step(rest)
    assert not truncated.any()
    assert (lifts.unwrapped.copies.batch.time > 0.0).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"arm": "ur6"}, "ur6"),
        ({"gripper": "none"}, "need a gripper"),
        ({"gripper": "2f86"}, "2f86"),
        ({"action": "torque"}, "action must be one of joint, cartesian, pose"),
        ({"observation": "pixels"}, "observation must be one of state, dict, goal"),
        ({"reward": "shaped"}, "reward must be one of dense, sparse"),
        ({"acton": "joint"}, "unknown option 'acton'; did you mean 'action'"),
        ({"control_rate": 30.0}, "whole number of steps"),
        ({"control_rate": 0.0}, "control_rate must be 1 … 200 Hz"),
        ({"control_rate": float("nan")}, "control_rate must be"),
        ({"dt": 0.1}, "dt must be above 0"),
        ({"randomise": 0.5}, "randomise must be True, False"),
        ({"camera": "wirst"}, "no camera 'wirst'; did you mean 'wrist'"),
        ({"camera": ["scene", "scene"]}, "camera must be a name.*several different"),
        ({"camera": ()}, "camera must be a name"),
        ({"camera": 3}, "camera must be a name"),
        ({"depth": True}, "depth needs observation='image'"),
        ({"arm": ["ur5"]}, "arm must be one name"),
        ({"gripper": None}, "gripper must be one name"),
        ({"terminate_on_success": "no"}, "terminate_on_success must be True or False"),
        ({"threads": "2"}, "threads"),
        ({"image_size": 64}, "image_size must be two numbers"),
    ],
)
def test_a_wrong_option_is_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(Tool0Error, match=message):
        make("Lift", **options)


def test_an_unknown_task_is_refused_with_the_known_ones() -> None:
    with pytest.raises(gymnasium.error.NameNotFound, match="Did you mean"):
        gymnasium.make("tool0/Lfit-v0")


@pytest.mark.parametrize("low", [0.0, float("nan"), -1.0, float("inf")])
def test_impossible_ranges_are_refused(low: float) -> None:
    with pytest.raises(Tool0Error, match=r"randomise\.mass"):
        tool0.gym.Randomisation(mass=(low, 1.0))
    with pytest.raises(Tool0Error, match="joint_noise"):
        tool0.gym.Randomisation(joint_noise=float("nan"))


def test_impossible_vector_environments_are_refused() -> None:
    with pytest.raises(Tool0Error, match="0"):
        make_vec("Reach", 0)
    with pytest.raises(Tool0Error, match="autoreset_mode must be one of NextStep"):
        make_vec("Reach", 1, autoreset_mode="never")
    with pytest.raises(Tool0Error, match="render_mode must be rgb_array or None"):
        make_vec("Reach", 1, render_mode="human")
    with pytest.raises(Tool0Error, match="max_episode_steps must be above 0"):
        make_vec("Reach", 1, max_episode_steps=0)


def test_wrong_actions_are_refused_and_nothing_moves(lifts: Any) -> None:
    rest = np.zeros(lifts.action_space.shape, np.float32)
    with pytest.raises(Tool0Error, match="must be reset before its first step"):
        lifts.step(rest)
    lifts.reset(seed=0)
    wrong = rest.copy()
    wrong[1, 3] = np.nan
    with pytest.raises(Tool0Error, match="copy 1 is NaN for 'yaw'"):
        lifts.step(wrong)
    with pytest.raises(Tool0Error, match=r"has shape \(3, 4\); it must be \(3, 5\)"):
        lifts.step(rest[:, :4])
    with pytest.raises(Tool0Error, match="must be numbers of shape"):
        lifts.step([["up"] * 5] * 3)
    with pytest.raises(Tool0Error, match="2 seeds for 3 copies"):
        lifts.reset(seed=[1, 2])
    assert (lifts.unwrapped.copies.batch.time == 0.0).all()


def test_a_wrong_action_of_one_copy_is_refused() -> None:
    env = make("Reach").unwrapped
    with pytest.raises(Tool0Error, match="must be reset before its first step"):
        env.step(np.zeros(5))
    env.reset(seed=0)
    with pytest.raises(Tool0Error, match=r"has shape \(1, 5\); it must be \(5,\)"):
        env.step(np.zeros((1, 5)))
    with pytest.raises(Tool0Error, match="NaN for 'x'"):
        env.step(np.array([np.nan, 0.0, 0.0, 0.0, 0.0]))
    with pytest.raises(Tool0Error, match=r"a goal has shape \(2,\)"):
        env.compute_reward(np.zeros(2), np.zeros(3), {})
    env.close()
    env.close()


def test_gymnasium_s_wrappers_fit() -> None:
    env = make_vec("Reach", 2, max_episode_steps=3)
    env = gymnasium.wrappers.vector.RecordEpisodeStatistics(env)
    env.reset(seed=0)
    for _ in range(3):
        *_, infos = env.step(np.zeros(env.action_space.shape, np.float32))
    assert (infos["episode"]["l"] == 3).all()
    env.close()
