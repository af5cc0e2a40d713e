"""Two arms in one task: a bar that changes hands, and tasks of one's own."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest
from promised import require_gl
from raises_naming import raises_naming

import tool0.gym
from tool0.collect import collect
from tool0.errors import ConfigError, ControlError
from tool0.gym import Hold, Start, State, Target, Task
from tool0.gym.benchmarks import handover
from tool0.policy import RunOptions, evaluate
from tool0.policy.task_environment import TaskEnvironment

pytestmark = pytest.mark.slow

ID, SEED = "tool0/Handover-v0", 1
ACTION = tuple(
    f"{arm}_{axis}"
    for arm in ("left", "right")
    for axis in ("x", "y", "z", "yaw", "gripper")
)


def many(n: int, **options: Any) -> Any:
    return gymnasium.make_vec(
        ID,
        num_envs=n,
        autoreset_mode="Disabled",
        terminate_on_success=False,
        **options,
    )


def open_grippers(n: int) -> np.ndarray:
    rest = np.zeros((n, len(ACTION)), np.float32)
    rest[:, [4, 9]] = 1.0
    return rest


class Taken(NamedTuple):
    """Two copies in which the bar has just changed hands."""

    envs: Any
    rewards: list[Any]
    """Of each step, shape (2,)."""
    actions: list[Any]
    """Of each step, shape (2, 10)."""


@pytest.fixture(scope="module")
def taken() -> Iterator[Taken]:
    envs = many(2)
    envs.reset(seed=SEED)
    expert = tool0.gym.expert(envs)
    rewards, actions = [], []
    for _ in range(150):
        actions.append(expert())
        _, reward, _, _, info = envs.step(actions[-1])
        rewards.append(reward)
        if info["is_success"].all():
            break
    assert info["is_success"].all()
    yield Taken(envs, rewards, actions)
    envs.close()


def test_numbers_are_named_by_arm() -> None:
    env = gymnasium.make(ID, observation="dict").unwrapped
    names = env.number_names  # type: ignore[attr-defined]
    assert names.action == ACTION
    assert names.grippers == (4, 9)
    seen, _ = env.reset(seed=0)
    for arm in ("left", "right"):
        joints = names.observations[f"{arm}_joint_position"]
        assert joints[0] == f"{arm}_shoulder_pan_joint.position"
        away = seen["bar_position"] - seen[f"{arm}_tcp_position"]
        np.testing.assert_allclose(seen[f"{arm}_tcp_to_bar"], away)
    around = names.surroundings
    assert "right_tcp_to_bar.x" in around
    assert not any("joint" in name or "gripper" in name for name in around)
    env.close()


def test_each_arm_moves_by_its_own_numbers() -> None:
    envs = many(2)
    envs.reset(seed=0)
    before = envs.unwrapped.copies.state.arms
    actions = open_grippers(2)
    actions[0, 2] = actions[1, 7] = 0.5
    for _ in range(4):
        envs.step(actions)
    after = envs.unwrapped.copies.state.arms
    risen = [
        after[arm].tcp_position[:, 2] - before[arm].tcp_position[:, 2]
        for arm in ("left", "right")
    ]
    assert (np.array(risen) > 0.02).tolist() == [[True, False], [False, True]]
    envs.close()


def test_only_the_first_arm_reaches_the_bar() -> None:
    env = gymnasium.make(ID, arm="ur5e", gripper="hande").unwrapped
    task = env.copies.task  # type: ignore[attr-defined]
    left, right = (task.workspace.of(arm) for arm in ("left", "right"))
    rng = np.random.default_rng(5)
    for _ in range(20):
        start = task.draw(rng)
        (place,), (yaw,) = start.places, start.yaws
        along = np.array([np.cos(yaw), np.sin(yaw), 0.0])
        ends = [place + side * handover.HELD_AT * along for side in (-1.0, 1.0)]
        assert all(left.can_lift(end[:2]) for end in ends)
        low = np.array([[*end[:2], right.lowest] for end in ends])
        assert not right.reaches_from_above(low)
    env.close()


def test_the_taker_alone_holds_the_bar_in_the_end(taken: Taken) -> None:
    copies = taken.envs.unwrapped.copies
    assert (copies.batch.pad_forces("right") > 20.0).all()
    twin = copy.deepcopy(copies)
    for _ in range(20):  # the giver is out of the way, and the bar still up
        twin.act(twin.checked(tool0.gym.Expert(twin, single=False)()))
    assert twin.successes().all()
    assert (twin.batch.pad_forces("left") == 0.0).all()
    away = twin.state.arms["left"].tcp_position - twin.state.object_position[:, 0]
    assert (away[:, 2] > 0.1).all()
    # Nothing is attached: it falls as soon as the pads open.
    for _ in range(15):
        twin.act(open_grippers(2).astype(float))
    assert (twin.task.achieved(twin.state)[:, 0] < 0.01).all()
    twin.batch.close()


def test_a_bar_that_one_arm_lifts_is_not_handed_over() -> None:
    envs = many(2)
    envs.reset(seed=3)
    expert = tool0.gym.expert(envs)
    for _ in range(70):
        actions = expert()
        actions[:, 5:] = open_grippers(2)[:, 5:]  # the other arm waits
        *_, info = envs.step(actions)
        assert not info["is_success"].any()
    height, taken, released = envs.unwrapped.copies.task.achieved(
        envs.unwrapped.copies.state
    ).T
    assert (height > handover.LIFTED).all()
    assert not taken.any()
    assert not released.any()
    envs.close()


def test_progress_grows_as_the_bar_changes_hands(taken: Taken) -> None:
    rewards = np.array(taken.rewards)
    assert (rewards.max(axis=0) == 0.0).all()
    assert (np.maximum.accumulate(rewards) - rewards).max() < 0.05


def test_the_expert_works_with_joint_actions_and_another_robot() -> None:
    envs = many(3, arm="ur5e", gripper="hande", action="joint", randomise=True)
    envs.reset(seed=3)
    expert = tool0.gym.expert(envs)
    done = np.zeros(3, dtype=bool)
    for _ in range(140):
        *_, info = envs.step(expert())
        done |= info["is_success"]
        if done.all():
            break
    assert done.all()
    envs.close()


def test_images_are_of_both_wrists() -> None:
    require_gl()
    cameras = ("scene", "left_wrist", "right_wrist")
    env = gymnasium.make(
        ID, observation="image", camera=cameras, image_size=(48, 36), randomise=True
    )
    seen, _ = env.reset(seed=0)
    assert env.observation_space.contains(seen)
    images = [seen[f"rgb_{name}"] for name in cameras]
    assert all(image.std() > 5.0 for image in images)
    assert (images[1] != images[2]).any()
    env.close()


def test_episodes_are_collected_in_lerobot_s_format(tmp_path: Path) -> None:
    made = collect("Handover", 1, tmp_path / "set", workers=1, format="lerobot")
    assert (made.n_episodes, made.n_succeeded) == (1, 1)
    features = json.loads((tmp_path / "set/meta/info.json").read_text())["features"]
    assert tuple(features["action"]["names"]) == ACTION
    assert "right_wrist_3_joint.position" in features["observation.state"]["names"]
    around = features["observation.environment_state"]["names"]
    assert "left_tcp_to_bar.z" in around


def test_a_policy_is_evaluated(taken: Taken) -> None:
    def replays(seed: int) -> Any:
        left = iter(taken.actions)
        return lambda observation: next(left)[0]

    run = RunOptions(max_steps=len(taken.actions))
    report = evaluate(replays, "Handover", [SEED], run=run)
    assert report.n_succeeded == 1


def test_grippers_stay_while_no_action_is_there() -> None:
    environment = TaskEnvironment("Handover", {})
    environment.begin(0)
    np.testing.assert_array_equal(environment.hold(), open_grippers(1)[0])
    action = np.linspace(-1.0, 0.8, 10)
    environment.act(action)
    held = environment.hold()
    assert held.tolist() == [*[0.0] * 4, action[4], *[0.0] * 4, action[9]]
    environment.close()


# ---- tasks of one's own ------------------------------------------------------------


class Meet(Task):
    """Bring both tools together; the first one carries a cube."""

    arms = ("one", "two")
    objects = ("cube",)
    goal_names = ("gap",)
    needs_wrench = True

    def __init__(self, workspace: Any) -> None:
        super().__init__(workspace)
        middle = (0.0, 0.0, workspace.grasp_height - workspace.edge / 2.0)
        self.hold = Hold(workspace.edge, middle)

    def scene(self) -> Any:
        return self.workspace.scene(self.objects, with_bin=True)

    def draw(self, rng: np.random.Generator) -> Start:
        places = self.workspace.draw_on_table(rng, 1)
        return Start(places, np.zeros(1), np.array([0.3]), is_held=True)

    def achieved(self, state: State) -> Any:
        one, two = (state.arms[arm].tcp_position for arm in self.arms)
        return np.linalg.norm(one - two, axis=1)[:, None]

    def is_success(self, achieved: Any, desired: Any) -> Any:
        return (achieved <= desired)[..., 0]

    def experts(self, state: State, commanded: Mapping[str, Any]) -> Any:
        middle = sum(pose.position for pose in commanded.values()) / 2.0
        return {
            arm: Target(middle, pose.yaw, 0.0 * pose.yaw, np.ones(len(pose.yaw)))
            for arm, pose in commanded.items()
        }


@pytest.fixture
def meet() -> Iterator[str]:
    tool0.gym.register("Meet-v0", Meet, max_episode_steps=60)
    yield "Meet-v0"
    gymnasium.registry.pop("Meet-v0", None)


@pytest.mark.parametrize("randomise", [False, True])
def test_the_first_arm_may_hold_an_object_at_the_start(
    meet: str, *, randomise: bool
) -> None:
    env = gymnasium.make(meet, observation="dict", randomise=randomise)
    seen, _ = env.reset(seed=2)
    copies = env.unwrapped.copies  # type: ignore[attr-defined]
    assert (copies.batch.pad_forces("one") > 20.0).all()
    assert np.linalg.norm(seen["one_tcp_to_cube"]) < 0.02
    assert seen["one_wrench"][2] != 0.0
    assert not seen["two_wrench"].any()
    expert = tool0.gym.expert(env)
    terminated = False
    while not terminated:
        _, _, terminated, truncated, _ = env.step(expert())
        assert not truncated
    env.close()


def test_a_state_of_two_arms_says_which_to_choose(meet: str) -> None:
    env = gymnasium.make(meet).unwrapped
    state = env.copies.state  # type: ignore[attr-defined]
    with raises_naming(ControlError, "one, two", "state.of('one')"):
        _ = state.q
    assert state.of("two").q is state.arms["two"].q
    with raises_naming(ControlError, "no arm 'tow'", "did you mean 'two'"):
        state.of("tow")
    with raises_naming(ConfigError, "no arm 'on'", "did you mean 'one'"):
        env.copies.workspace.of("on")  # type: ignore[attr-defined]
    env.close()


@pytest.mark.parametrize("arms", [("one",), ("one", "one"), ("a", "b", "c")])
def test_other_numbers_of_arms_are_refused(
    meet: str, arms: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Meet, "arms", arms)
    with raises_naming(ConfigError, "two different names", repr(arms)):
        gymnasium.make(meet)


def test_an_expert_for_one_of_two_arms_is_refused(
    meet: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    env = gymnasium.make(meet)
    env.reset(seed=0)
    whole = Meet.experts

    def half(self: Meet, state: State, commanded: Mapping[str, Any]) -> Any:
        return {"one": whole(self, state, commanded)["one"]}

    monkeypatch.setattr(Meet, "experts", half)
    with raises_naming(
        ConfigError, "task Meet: experts", "one; it must be", "one, two"
    ):
        tool0.gym.expert(env)()
    monkeypatch.setattr(Meet, "experts", Task.experts)
    with raises_naming(ConfigError, "Meet has no expert", "`experts`"):
        tool0.gym.expert(env)
    env.close()
