"""Episodes whose objects differ in size: what is drawn, observed and solved."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from raises_naming import raises_naming

import tool0.gym
from tool0.api.table import TABLE_TOP
from tool0.description.shapes import extents, sizes
from tool0.errors import ConfigError
from tool0.gym.copies import Copies
from tool0.gym.options import EnvOptions
from tool0.gym.workspace import workspaces
from tool0.scene import Cylinder, Scene, Sphere

pytestmark = pytest.mark.slow

RANGES = tool0.gym.Randomisation(size=(0.6, 1.5))
CUBES = ("Lift", "PickPlace", "Stack", "Push")


def make_vec(task: str, n: int, **options: Any) -> Any:
    options = {"randomise": RANGES, **options}
    return gymnasium.make_vec(f"tool0/{task}-v0", num_envs=n, **options)


@pytest.mark.parametrize("task", CUBES)
def test_experts_use_the_size_of_each_copy(task: str) -> None:
    n = 4
    env = make_vec(task, n, terminate_on_success=False)
    act = tool0.gym.expert(env)
    observed, _ = env.reset(seed=0)
    copies = env.unwrapped.copies
    edges = copies.state.object_size[..., 0].copy()
    assert len(np.unique(edges)) == edges.size
    assert np.ptp(edges / copies.workspace.edge) > 0.4
    done = np.zeros(n, dtype=bool)
    for _ in range(env.spec.max_episode_steps - 1):
        observed, _, _, _, info = env.step(act(observed))
        done |= info["is_success"]
        if done.all():
            break
    assert done.all()
    env.close()


def test_objects_stand_on_the_table_and_are_seen() -> None:
    env = make_vec("Stack", 4, observation="dict")
    observed, _ = env.reset(seed=3)
    copies = env.unwrapped.copies
    for name in copies.task.objects:
        size = copies.batch.object_size(name)
        np.testing.assert_array_equal(observed[f"{name}_size"], size)
        bottom = observed[f"{name}_position"][:, 2] - size[:, 2] / 2.0
        np.testing.assert_allclose(bottom, TABLE_TOP, atol=1e-9)
    still = np.zeros(env.action_space.shape, np.float32)
    for _ in range(4):
        observed, *_ = env.step(still)
    for name in copies.task.objects:
        assert np.abs(observed[f"{name}_velocity"]).max() < 0.01
    size = observed["cube_size"] + observed["lower_cube_size"]
    above = observed["goal"][:, 2] - observed["lower_cube_position"][:, 2]
    np.testing.assert_allclose(above, size[:, 2] / 2.0)
    env.close()


def test_a_copy_is_the_single_environment_and_goes_on_alike() -> None:
    many = make_vec("Lift", 3)
    single = gymnasium.make("tool0/Lift-v0", randomise=RANGES)
    rows, _ = many.reset(seed=5)
    one, _ = single.reset(seed=7)
    np.testing.assert_array_equal(rows[2], one)
    action = np.full((3, 5), 0.3, np.float32)
    for _ in range(3):
        rows, *_ = many.step(action)
        one, *_ = single.step(action[2])
        np.testing.assert_array_equal(rows[2], one)
    twin = copy.deepcopy(single.unwrapped)
    np.testing.assert_array_equal(
        twin.step(action[2])[0], single.unwrapped.step(action[2])[0]
    )
    for env in (many, single, twin):
        env.close()


def test_sizes_change_nothing_else_that_is_drawn() -> None:
    """Places and turns are those of episodes with the usual size."""
    usual, other = make_vec("Lift", 3, randomise=True), make_vec("Lift", 3)
    first, _ = usual.reset(seed=2)
    second, _ = other.reset(seed=2)
    mine, its = (env.unwrapped.copies.state for env in (usual, other))
    np.testing.assert_array_equal(first[:, :6], second[:, :6])
    np.testing.assert_array_equal(mine.object_quat, its.object_quat)
    np.testing.assert_array_equal(
        mine.object_position[..., :2], its.object_position[..., :2]
    )
    assert first.shape[1] + 3 == second.shape[1]
    for env in (usual, other):
        env.close()


def test_the_checker_has_no_complaint() -> None:
    env = gymnasium.make("tool0/Push-v0", randomise=RANGES, observation="goal")
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


@pytest.mark.parametrize("gripper", ["2f85", "2f140", "hande"])
def test_the_gripper_can_grasp_every_size(gripper: str) -> None:
    ranges = tool0.gym.Randomisation(size=(0.01, 100.0))
    options = EnvOptions(gripper=gripper, randomise=ranges)
    (space,) = workspaces(options).values()
    smallest, largest = space.edges
    assert 0.01 < smallest < space.edge <= largest
    assert largest <= 0.8 * space.gripper.max_opening
    heights = space.grasp_heights(np.array([smallest, space.edge, largest]))
    assert (heights > space.reach).all()
    np.testing.assert_allclose(heights[1], space.grasp_height, atol=2e-5)


@pytest.mark.parametrize("task", ["Reach", "PegInsertion", "PickClutter"])
def test_tasks_with_fixed_sizes_say_so(task: str) -> None:
    with raises_naming(ConfigError, "randomise.size", task, "fixed", "resizable"):
        make_vec(task, 1)


def test_wrong_ranges_are_refused() -> None:
    with raises_naming(ConfigError, "randomise.size", "smaller first", "(1.5, 0.5)"):
        tool0.gym.Randomisation(size=(1.5, 0.5))
    with raises_naming(ConfigError, "randomise.size", "gripper", "times"):
        make_vec("Lift", 1, randomise=tool0.gym.Randomisation(size=(5.0, 6.0)))


def test_they_need_the_cpu() -> None:
    pytest.importorskip("mujoco_warp")
    with raises_naming(ConfigError, "randomise.size", "device='cpu'", "'warp:cpu'"):
        make_vec("Lift", 1, device="warp:cpu")


class _Resized(tool0.gym.Task):
    """A task whose objects are to have random sizes."""

    objects = ("cube",)
    goal_names = ("x",)

    def scene(self) -> Any:
        return self.workspace.scene(("cube",))

    def draw(self, rng: np.random.Generator) -> tool0.gym.Start:
        places = self.workspace.draw_on_table(rng, 1)
        return tool0.gym.Start(places, np.zeros(1), np.zeros(1))

    def achieved(self, state: tool0.gym.State) -> Any:
        return state.object_position[:, 0, :1]

    def is_success(self, achieved: Any, desired: Any) -> Any:
        return (achieved > desired)[..., 0]


@pytest.mark.parametrize(
    "shape", [Sphere(radius=0.02), Cylinder(radius=0.02, length=0.05)]
)
def test_other_shapes_in_tasks_of_ones_own(shape: Sphere | Cylinder) -> None:
    class Rounded(_Resized):
        resizable = ("cube",)

        def scene(self) -> Scene:
            *others, cube = super().scene().objects
            return Scene((*others, replace(cube, geometry=shape)))

    copies = Copies(Rounded, 2, EnvOptions(randomise=RANGES))
    generators = [np.random.default_rng(k) for k in range(2)]
    copies.reset(np.array([True, True]), generators)
    size = copies.batch.object_size("cube").reshape(2, -1)
    factor = size[:, 0] / 0.02
    assert (np.diff(factor) != 0.0).all()
    assert RANGES.size[0] <= factor.min() <= factor.max() <= RANGES.size[1]
    np.testing.assert_allclose(size, np.outer(factor, sizes(shape)))
    extent = np.outer(factor, extents(shape))
    np.testing.assert_allclose(copies.state.object_size[:, 0], extent)
    first = copies.state.object_size
    copies.reset(np.array([False, True]), generators)
    again = copies.state.object_size
    assert (again == first).all(axis=(1, 2)).tolist() == [True, False]


@pytest.mark.parametrize(
    ("attributes", "shown"),
    [
        ({"resizable": ("box",)}, ("'box'", "no box, cylinder or sphere")),
        (
            {"resizable": ("cube",), "hold": tool0.gym.Hold(0.045)},
            ("'cube'", "in the gripper"),
        ),
    ],
)
def test_what_cannot_be_resizable(
    attributes: dict[str, Any], shown: tuple[str, ...]
) -> None:
    task = type("Odd", (_Resized,), attributes)
    with raises_naming(ConfigError, "Odd", *shown):
        Copies(task, 1, EnvOptions(randomise=RANGES))
