"""Episodes of a task in a simulated Gymnasium environment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from tool0.collect.rollout import flat
from tool0.collect.tasks import default_instruction, environment_spec, located_task
from tool0.errors import ConfigError
from tool0.policy.environment import Array, Outcome, Picture
from tool0.policy.seen import Seen

VIDEO_SIZE: Final = (320, 240)
"""Size of a video's images if the observations contain no images [pixels]."""


@final
class TaskEnvironment:
    """A Gymnasium environment in which time is paused while the policy computes."""

    is_realtime = False

    def __init__(
        self,
        task: str,
        options: Mapping[str, Any],
        *,
        instruction: str | None = None,
        draws: bool = False,
    ) -> None:
        """Create the environment.

        Args:
            task: Name of the task; see ``tool0.collect.collect``.
            options: Keyword arguments of the environment.
            instruction: Instruction for the policy; the default is the instruction of
                the task.
            draws: Whether to render images for videos.

        Raises:
            ConfigError: If there is no such task.
            Tool0Error: If an option is wrong.
        """
        import gymnasium

        from tool0.gym.registration import task_of

        self.task, self.digest = located_task(task)
        spec = environment_spec(self.task, self.digest)
        given = dict(options)
        is_own = task_of(spec) is not None
        if draws:
            given["render_mode"] = "rgb_array"
            if is_own and given.get("observation") != "image":
                given.setdefault("image_size", VIDEO_SIZE)
        self.instruction = instruction
        if instruction is None:
            self.instruction = default_instruction(self.task, self.digest)
        self._env: Any = gymnasium.make(spec, **given)
        self._draws = draws
        rate = self._env.metadata.get("render_fps")
        if not rate:
            raise ConfigError(f"task '{task}': its metadata lack render_fps [Hz]")
        self.rate = float(rate)
        space = self._env.action_space
        if not (isinstance(space, gymnasium.spaces.Box) and space.is_bounded()):
            raise ConfigError(
                f"task '{task}': its actions are {space}; they must be numbers with "
                "bounds"
            )
        self._space = space
        self.limits = (
            space.low.astype(np.float64).ravel(),
            space.high.astype(np.float64).ravel(),
        )
        names = getattr(self._env.unwrapped, "number_names", None)
        width = len(self.limits[0])
        self.action_names: tuple[str, ...] = (
            tuple(names.action) if names else tuple(f"action.{k}" for k in range(width))
        )
        self._names = names.observations if names else {}
        self._surroundings = names.surroundings if names else frozenset()
        self._grippers = list(names.grippers) if names else []
        self._last = np.zeros(width)
        self._observation: Any = None

    @property
    def names(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the components of the observations and of the action."""
        return {**self._names, "action": self.action_names}

    @property
    def surroundings(self) -> frozenset[str]:
        """Names of the numbers that the robot's sensors cannot measure."""
        return self._surroundings

    def begin(self, seed: int) -> None:
        """Begin the episode with a seed."""
        self._observation, _ = self._env.reset(seed=seed)
        self._last = np.zeros_like(self._last)
        self._last[self._grippers] = 1.0  # the grippers are open

    def see(self) -> Seen:
        """Return the current observation of the environment."""
        values = dict(flat(self._observation))
        return Seen(
            observation=self._observation,
            values=values,
            kept=values,
            names=self._names,
            surroundings=self._surroundings,
            instruction=self.instruction or "",
        )

    def hold(self) -> Array:
        """Return the action that stops the tools and keeps the grippers' openings.

        In environments from other packages, the result is the allowed action closest to
        zero.
        """
        action = np.zeros_like(self._last)
        action[self._grippers] = self._last[self._grippers]
        return np.asarray(action.clip(*self.limits))

    def act(self, action: Array) -> Outcome:
        """Execute an action for one control period."""
        self._last = action
        given: NDArray[Any] = action.reshape(self._space.shape)
        self._observation, reward, terminated, truncated, info = self._env.step(
            given.astype(self._space.dtype)
        )
        success = bool(info.get("is_success", False))
        return Outcome(float(reward), bool(terminated), bool(truncated), success)

    def picture(self) -> Picture | None:
        """Return the camera's image, or None if images are not rendered."""
        return self._env.render() if self._draws else None

    def end(self) -> None:
        """Do nothing, because simulated time is paused between actions."""

    def close(self) -> None:
        """Close the simulation."""
        self._env.close()
