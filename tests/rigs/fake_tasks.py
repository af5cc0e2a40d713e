"""Small environments and policies to collect from; workers import this module."""

from __future__ import annotations

import os
import signal
import time
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces

RATE = 20


class Walk(gymnasium.Env[Any, Any]):
    """A point that has to come near the origin; it starts where the seed says."""

    metadata: ClassVar[dict[str, Any]] = {"render_modes": [], "render_fps": RATE}
    observation_space = spaces.Dict(
        {
            "position": spaces.Box(-9.0, 9.0, (2,)),
            "time": spaces.Box(0.0, 1e3, (1,), np.float64),
        }
    )
    action_space = spaces.Box(-1.0, 1.0, (2,))

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        self._position = self.np_random.uniform(-2.0, 2.0, 2)
        self._n_steps = 0
        return self._observation(), {}

    def step(self, action: Any) -> Any:
        self._position += 0.2 * action + 0.01 * self.np_random.normal(size=2)
        self._n_steps += 1
        distance = float(np.abs(self._position).max())
        success = distance < 0.3
        is_over = self._n_steps == 40
        return self._observation(), -distance, success, is_over, {"is_success": success}

    def _observation(self) -> dict[str, Any]:
        time = np.array([self._n_steps / RATE])
        return {"position": self._position.astype(np.float32), "time": time}


class Pictures(gymnasium.ObservationWrapper[Any, Any, Any]):
    """The same, with an image."""

    def __init__(self) -> None:
        super().__init__(Walk())
        image = spaces.Box(0, 255, (8, 12, 3), np.uint8)
        self.observation_space = spaces.Dict({**Walk.observation_space, "rgb": image})

    def observation(self, observation: Any) -> Any:
        level = int(np.abs(observation["position"]).sum() * 50) % 256
        return {**observation, "rgb": np.full((8, 12, 3), level, np.uint8)}


gymnasium.register("Walk-v0", Walk)
gymnasium.register("Pictures-v0", Pictures)

WALK = "fake_tasks:Walk-v0"
PICTURES = "fake_tasks:Pictures-v0"


class Homeward:
    """Goes to the origin; how fast is drawn once per episode.

    TOOL0_TEST_PACE is the time that an episode takes at least [wall s].
    """

    def __init__(self, seed: int) -> None:
        time.sleep(float(os.environ.get("TOOL0_TEST_PACE", "0")))
        self._speed = np.random.default_rng(seed).uniform(0.2, 1.0)

    def __call__(self, observation: Any) -> Any:
        return np.clip(-self._speed * observation["position"], -1.0, 1.0)


def deadly(seed: int) -> Homeward:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def failing(seed: int) -> Homeward:
    raise ValueError(f"no action for {seed}")


def malformed(seed: int) -> Any:
    return lambda observation: np.zeros(3)
