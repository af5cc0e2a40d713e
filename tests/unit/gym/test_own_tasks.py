"""Tasks of one's own: written in a user's file, used as those of tool0."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from raises_naming import raises_naming

import tool0.gym
from tool0.collect import collect
from tool0.errors import ConfigError
from tool0.gym import Start, State, Task, Workspace

EXAMPLE = Path(__file__).parents[3] / "examples/29_own_task.py"
ID = "Coaster-v0"


@pytest.fixture(scope="module")
def coaster() -> Iterator[ModuleType]:
    """The task of the example, imported as a user's module."""
    spec = importlib.util.spec_from_file_location("coaster_task", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["coaster_task"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["coaster_task"]
    gymnasium.registry.pop(ID, None)


def test_it_is_an_environment_of_gymnasium(coaster: ModuleType) -> None:
    env = gymnasium.make(f"coaster_task:{ID}", observation="goal")
    check_env(env.unwrapped, skip_render_check=True)
    assert env.unwrapped.number_names.surroundings >= {  # type: ignore[attr-defined]
        "coaster.x",
        "desired_goal.released",
    }
    env.close()


@pytest.mark.slow
def test_its_expert_solves_it(coaster: ModuleType) -> None:
    envs = gymnasium.make_vec(f"coaster_task:{ID}", num_envs=20)
    expert = tool0.gym.expert(envs)
    state, _ = envs.reset(seed=7)
    solved = np.zeros(20, bool)
    for _ in range(120):
        state, reward, terminated, _, _ = envs.step(expert(state))
        assert ((reward >= -1.0) & (reward <= 0.0)).all()
        solved |= terminated
    assert solved.sum() >= 19
    envs.close()


@pytest.mark.slow
def test_its_episodes_are_collected_from_a_file(tmp_path: Path) -> None:
    manifest = collect(f"{EXAMPLE}:{ID}", 3, tmp_path / "set", workers=1)
    assert (manifest.n_episodes, manifest.n_succeeded) == (3, 3)
    text = (tmp_path / "set/manifest.json").read_text()
    assert f"{ID}@sha256:" in text
    assert str(EXAMPLE) not in text


def test_a_file_that_is_not_there_or_has_no_such_task(tmp_path: Path) -> None:
    with raises_naming(ConfigError, "none.py:A-v0", "cannot be read"):
        collect(f"{tmp_path}/none.py:A-v0", 1, tmp_path / "a")
    (tmp_path / "wrong.py").write_text("1 / 0\n")
    with raises_naming(ConfigError, "wrong.py:A-v0", "ZeroDivisionError"):
        collect(f"{tmp_path}/wrong.py:A-v0", 1, tmp_path / "b")
    (tmp_path / "empty.py").write_text("")
    with raises_naming(ConfigError, "empty.py:Other-v0", "Other"):
        collect(f"{tmp_path}/empty.py:Other-v0", 1, tmp_path / "c")


class Hover(Task):
    """The least that a task needs: move the tcp above a cube."""

    objects = ("cube",)
    goal_names = ("x", "y", "z")

    def scene(self) -> Any:
        return self.workspace.scene(self.objects)

    def draw(self, rng: np.random.Generator) -> Start:
        places = self.workspace.draw_on_table(rng, 1)
        return Start(places, np.zeros(1), places[0] + [0.0, 0.0, 0.15])

    def achieved(self, state: State) -> Any:
        return state.tcp_position

    def is_success(self, achieved: Any, desired: Any) -> Any:
        return self.distance(achieved, desired) < 0.01

    def observe(self, state: State) -> Any:
        return {"height": state.tcp_position[:, 2], "twice": 2.0 * state.q[:, :2]}


@pytest.fixture
def hover() -> Iterator[None]:
    tool0.gym.register("Hover-v0", Hover, max_episode_steps=5, control_rate=50.0)
    yield
    gymnasium.registry.pop("Hover-v0", None)


def test_what_is_left_out_has_a_default(hover: None) -> None:
    env = gymnasium.make("Hover-v0", observation="dict")
    seen, _ = env.reset(seed=1)
    assert seen["height"] == seen["tcp_position"][2:]
    assert seen["twice"] == pytest.approx(2.0 * seen["joint_position"][:2])
    _, reward, _, _, _ = env.step(env.action_space.sample())
    assert -1.0 < float(reward) < 0.0
    assert env.metadata["render_fps"] == 50.0
    with raises_naming(ConfigError, "task Hover has no expert", "method `expert`"):
        tool0.gym.expert(env)
    env.close()


def test_copies_are_those_of_single_environments(hover: None) -> None:
    many = gymnasium.make_vec("Hover-v0", num_envs=3)
    many.reset(seed=10)
    one = gymnasium.make("Hover-v0")
    one.reset(seed=12)
    action = np.full(5, 0.5, np.float32)
    states, rewards, *_ = many.step(np.tile(action, (3, 1)))
    state, reward, *_ = one.step(action)
    assert (states[2] == state).all()
    assert rewards[2] == reward
    many.close()
    one.close()


class _Wrong(Hover):
    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)


class NoStart(_Wrong):
    def draw(self, rng: np.random.Generator) -> Any:
        return [1.0, 2.0]


class FlatPlaces(_Wrong):
    def draw(self, rng: np.random.Generator) -> Start:
        return Start(np.zeros(3), np.zeros(1), np.zeros(3))


class NarrowGoal(_Wrong):
    def achieved(self, state: State) -> Any:
        return state.tcp_position[:, :2]

    def desired(self, state: State) -> Any:
        return state.goal[:, :2]


class NumberSuccess(_Wrong):
    def is_success(self, achieved: Any, desired: Any) -> Any:
        return self.distance(achieved, desired)


class OneReward(_Wrong):
    def reward(self, state: State, success: Any) -> Any:
        return 0.5


class WrongPart(_Wrong):
    def observe(self, state: State) -> Any:
        return {"height": 1.0}


class NoObject(_Wrong):
    objects = ("cup",)

    def scene(self) -> Any:
        return self.workspace.scene(("cube",))


class HeldWithoutHold(_Wrong):
    def draw(self, rng: np.random.Generator) -> Start:
        return super().draw(rng)._replace(is_held=True)


@pytest.mark.parametrize(
    ("task", "named"),
    [
        (NoStart, ("draw is a list", "tool0.gym.Start")),
        (FlatPlaces, ("draw: places is shape (3,)", "(1, 3)")),
        (NarrowGoal, ("achieved is shape (1, 2)", "(1, 3)")),
        (NumberSuccess, ("is_success is float64", "booleans")),
        (OneReward, ("reward is shape ()", "(1,)")),
        (WrongPart, ("observe: height is shape ()", "(1, m)")),
        (NoObject, ("no object 'cup' in its scene",)),
        (HeldWithoutHold, ("draw: is_held is True", "hold")),
    ],
)
def test_a_wrong_function_is_named(task: type[Task], named: tuple[str, ...]) -> None:
    tool0.gym.register("Wrong-v0", task, max_episode_steps=5)
    try:
        with raises_naming(ConfigError, f"task {task.__name__}", *named):
            gymnasium.make("Wrong-v0")
    finally:
        gymnasium.registry.pop("Wrong-v0", None)


def test_what_is_registered_is_a_task() -> None:
    with raises_naming(ConfigError, "no subclass of tool0.gym.Task"):
        tool0.gym.register("A-v0", dict, max_episode_steps=5)  # type: ignore[arg-type]
    with raises_naming(ConfigError, "max_episode_steps", "0"):
        tool0.gym.register("A-v0", Hover, max_episode_steps=0)
    with raises_naming(ConfigError, "'armm'", "arm"):
        tool0.gym.register("A-v0", Hover, max_episode_steps=5, armm="ur5e")
