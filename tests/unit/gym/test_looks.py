"""Images of environments that look different in each episode, and what they show."""

from __future__ import annotations

import copy
from typing import Any

import gymnasium
import numpy as np
import pytest
from promised import require_gl
from raises_naming import raises_naming

import tool0.gym
from tool0.errors import ConfigError

pytestmark = pytest.mark.slow

IMAGES = {"observation": "image", "image_size": (64, 48)}


def made(**options: Any) -> Any:
    return gymnasium.make("tool0/Lift-v0", **IMAGES, **options).unwrapped


def test_an_episode_looks_as_its_seed_says_and_its_copy_alike() -> None:
    require_gl()
    env, other = made(randomise=True), made(randomise=True)
    first, _ = env.reset(seed=1)
    second, _ = env.reset(seed=2)
    again, _ = other.reset(seed=1)
    np.testing.assert_array_equal(first["rgb"], again["rgb"])
    assert np.abs(first["rgb"].astype(int) - second["rgb"]).mean() > 5.0
    twin = copy.deepcopy(env)
    action = np.zeros(5)
    mine, its = env.step(action)[0], twin.step(action)[0]
    np.testing.assert_array_equal(mine["rgb"], its["rgb"])
    for each in (env, other, twin):
        each.close()


def test_looks_change_no_motion() -> None:
    require_gl()
    plain = gymnasium.make("tool0/Lift-v0", randomise=True).unwrapped
    seen = made(randomise=True)
    np.testing.assert_array_equal(
        plain.reset(seed=3)[0], seen.reset(seed=3)[0]["state"]
    )
    plain.close()
    seen.close()


def test_each_pixel_says_what_it_shows() -> None:
    require_gl()
    none = tool0.gym.Randomisation(camera=0.0, camera_turn=0.0)
    env = made(segmentation=True, depth=True, randomise=none)
    seen, _ = env.reset(seed=0)
    segments, rgb = seen["segmentation"], seen["rgb"].astype(int)
    assert env.observation_space["segmentation"].contains(segments)
    names = env.copies.batch.object_names
    assert set(np.unique(segments)) == {-2, -1, *range(len(names))}
    cube, table = (segments == names.index(name) for name in ("cube", "table"))
    assert 4 < cube.sum() < 60 < table.sum()
    reddish = rgb[..., 0] - rgb[..., 2]  # the cube is orange, the table is not
    assert reddish[cube].mean() > reddish[table].mean() + 20
    assert seen["depth"][segments == -1].max() < seen["depth"][segments == -2].max()
    env.close()


@pytest.mark.parametrize(
    ("options", "shown"),
    [
        ({"colour": 1.5}, "randomise.colour must be 0 … 1"),
        ({"brightness": (0.5, 9.0)}, "randomise.brightness must be at most 3"),
        ({"camera": -0.1}, "randomise.camera must be 0 … 0.2 m"),
    ],
)
def test_wrong_ranges_are_refused(options: dict[str, Any], shown: str) -> None:
    with raises_naming(ConfigError, shown):
        tool0.gym.Randomisation(**options)


def test_segmentation_needs_images() -> None:
    with raises_naming(ConfigError, "segmentation needs observation='image'"):
        gymnasium.make("tool0/Lift-v0", segmentation=True)
