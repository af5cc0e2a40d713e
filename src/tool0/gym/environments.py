"""Gymnasium environments with one or many copies of a task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, final

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from tool0.errors import ConfigError, ControlError
from tool0.gym.copies import Copies
from tool0.gym.observations import NumberNames, Observation, Observer, row
from tool0.gym.options import read_options
from tool0.gym.task import Mask, Task
from tool0.kinematics.chain import Array

RENDER_MODES = ["rgb_array"]


@final
class TaskEnv(gymnasium.Env[Any, Any]):
    """Environment with one copy of a task, inside Gymnasium's wrappers."""

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES}  # noqa: RUF012  # theirs

    def __init__(
        self,
        task: str | type[Task],
        render_mode: str | None = None,
        **options: object,
    ) -> None:
        """Make the environment.

        Args:
            task: Name of a built-in task, such as ``Lift``, or a class derived from
                ``Task``.
            render_mode: ``rgb_array``, or None.
            options: Fields of ``EnvOptions``.

        Raises:
            Tool0Error: If an option is wrong.
        """
        self.render_mode = _checked_render_mode(render_mode)
        read = read_options(options)
        self.metadata = {**self.metadata, "render_fps": read.control_rate}
        self.copies = Copies(task, 1, read)
        self._observer = Observer(self.copies)
        self.observation_space = self._observer.space
        self.action_space = _action_space(self.copies)
        self._is_reset = False

    @property
    def state_slices(self) -> Mapping[str, slice]:
        """The slice of each part in the flat state."""
        return self._observer.slices

    @property
    def number_names(self) -> NumberNames:
        """The names of the numbers of observations and actions."""
        return self._observer.names

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode; the same ``seed`` always starts the same episode."""
        super().reset(seed=seed)
        self.copies.reset(np.ones(1, dtype=bool), [self.np_random])
        self._is_reset = True
        return row(self._observer.observe(), 0), self._info(self.copies.successes())

    def step(self, action: ArrayLike) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Apply an action for one control period.

        Raises:
            ControlError: If the action has a wrong shape or contains NaN, or the
                environment has not been reset.
        """
        if not self._is_reset:
            raise ControlError("the environment must be reset before its first step")
        copies = self.copies
        wanted = (len(copies.actions.names),)
        given = np.asarray(action)
        if given.shape != wanted:
            raise ControlError(
                f"the action has shape {given.shape}; it must be {wanted} for "
                f"{', '.join(copies.actions.names)}"
            )
        copies.act(copies.checked(given[None]))
        success = copies.successes()
        reward = float(copies.rewards(success)[0])
        terminated = bool(success[0]) and copies.options.terminate_on_success
        truncated = bool(copies.batch.diverged[0])
        observation = row(self._observer.observe(), 0)
        return observation, reward, terminated, truncated, self._info(success)

    def compute_reward(
        self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: object
    ) -> Array | np.float64:
        """Return the rewards of achieved goals, shape (…); ``info`` is ignored."""
        return _goal_rewards(self.copies, achieved_goal, desired_goal)

    def render(self) -> NDArray[np.uint8] | None:
        """Return an image, shape (height, width, 3), in mode ``rgb_array``."""
        return None if self.render_mode is None else self.copies.image(0)

    def close(self) -> None:
        """End the simulation; further calls have no effect."""
        if hasattr(self, "copies"):
            self.copies.batch.close()

    def _info(self, success: Mask) -> dict[str, Any]:
        return {
            "is_success": bool(success[0]),
            "diverged": bool(self.copies.batch.diverged[0]),
        }


@final
class TaskVectorEnv(gymnasium.vector.VectorEnv[Any, Any, NDArray[Any]]):
    """Environment with many copies of a task, which ``gymnasium.make_vec`` returns.

    All copies are stepped together.  After ``reset(seed=s)``, copy i behaves, bit for
    bit, like a single environment after ``reset(seed=s + i)``, regardless of the number
    of copies.
    """

    def __init__(
        self,
        task: str | type[Task],
        num_envs: int = 1,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        **options: object,
    ) -> None:
        """Make the environments.

        Args:
            task: Name of a built-in task, such as ``Lift``, or a class derived from
                ``Task``.
            num_envs: Number of copies.
            render_mode: ``rgb_array``, or None.
            max_episode_steps: Number of actions after which an episode is truncated.
            autoreset_mode: When to reset a copy after its episode has ended: NEXT_STEP,
                SAME_STEP or DISABLED.
            options: Fields of ``EnvOptions``.

        Raises:
            Tool0Error: If an option is wrong.
        """
        self.render_mode = _checked_render_mode(render_mode)
        self.autoreset_mode = _checked_autoreset_mode(autoreset_mode)
        read = read_options(options)
        self.metadata = {
            "render_modes": RENDER_MODES,
            "render_fps": read.control_rate,
            "autoreset_mode": self.autoreset_mode,
        }
        if max_episode_steps is not None and not max_episode_steps > 0:
            raise ConfigError(
                f"max_episode_steps must be above 0, got {max_episode_steps}"
            )
        self.copies = Copies(task, num_envs, read)
        self.num_envs = num_envs
        self._observer = Observer(self.copies)
        self.single_observation_space = self._observer.space
        self.single_action_space = _action_space(self.copies)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._max_steps = max_episode_steps
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._has_ended = np.zeros(num_envs, dtype=bool)
        self._generators: list[np.random.Generator] = []

    @property
    def state_slices(self) -> Mapping[str, slice]:
        """The slice of each part in the flat state."""
        return self._observer.slices

    @property
    def number_names(self) -> NumberNames:
        """The names of the numbers of observations and actions."""
        return self._observer.names

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode of each copy.

        Args:
            seed: Copy i gets ``seed + i``, or entry i of a sequence.  If the value is
                None, the copy's random generator continues.
            options: ``reset_mask``, shape (num_envs,), selects the copies to reset.

        Raises:
            ControlError: If the number of seeds is wrong, or the mask has a wrong
                shape.
        """
        n = self.num_envs
        seeds = _seeds(seed, n)
        which = _reset_mask(options, n)
        if not self._generators:
            self._generators = [seeding.np_random(one)[0] for one in seeds]
        else:
            for i, one in enumerate(seeds):
                if one is not None and which[i]:
                    self._generators[i] = seeding.np_random(one)[0]
        self._restart(which)
        return self._observer.observe(), self._infos(self.copies.successes())

    def step(
        self, actions: ArrayLike
    ) -> tuple[Any, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Apply an action for one control period in each copy.

        If ``autoreset_mode`` is NEXT_STEP, a copy whose episode ended in the previous
        step ignores its action and starts a new episode.

        Raises:
            ControlError: If the actions have a wrong shape or contain NaN, the
                environment has not been reset, or a copy whose episode has ended was
                not reset.
        """
        if not self._generators:
            raise ControlError("the environment must be reset before its first step")
        copies, fresh = self.copies, self._has_ended
        if fresh.any() and self.autoreset_mode is AutoresetMode.DISABLED:
            raise ControlError(
                f"the episodes of copies {np.flatnonzero(fresh).tolist()} have ended; "
                "reset them with options={'reset_mask': …}"
            )
        copies.act(copies.checked(actions))
        self._steps += 1
        if fresh.any():
            self._restart(fresh)
        success = copies.successes()
        rewards = np.where(fresh, 0.0, copies.rewards(success))
        terminated = success & ~fresh & copies.options.terminate_on_success
        truncated = copies.batch.diverged & ~fresh
        if self._max_steps is not None:
            truncated = truncated | (self._steps >= self._max_steps)
        observation, infos = self._observer.observe(), self._infos(success)
        ended = terminated | truncated
        if self.autoreset_mode is AutoresetMode.SAME_STEP and ended.any():
            final = _final(observation, infos, ended)
            self._restart(ended)
            observation = self._observer.observe()
            infos = {**self._infos(copies.successes()), **final}
        elif self.autoreset_mode is not AutoresetMode.SAME_STEP:
            self._has_ended = ended
        return observation, rewards, terminated, truncated, infos

    def compute_reward(
        self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: object
    ) -> Array | np.float64:
        """Return the rewards of achieved goals, shape (…); ``info`` is ignored."""
        return _goal_rewards(self.copies, achieved_goal, desired_goal)

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return an image of each copy in mode ``rgb_array``."""
        if self.render_mode is None:
            return None
        return tuple(self.copies.image(i) for i in range(self.num_envs))

    def close_extras(self, **_: object) -> None:
        """End the simulation."""
        if hasattr(self, "copies"):
            self.copies.batch.close()

    def _restart(self, which: Mask) -> None:
        self.copies.reset(which, self._generators)
        self._steps[which] = 0
        self._has_ended = self._has_ended & ~which

    def _infos(self, success: Mask) -> dict[str, Any]:
        n = self.num_envs
        return {
            "is_success": success.copy(),
            "_is_success": np.ones(n, dtype=bool),
            "diverged": self.copies.batch.diverged.copy(),
            "_diverged": np.ones(n, dtype=bool),
        }


def _final(
    observation: Observation, infos: Mapping[str, Any], ended: Mask
) -> dict[str, Any]:
    """Return the final observations and infos of ended episodes for Gymnasium."""
    final = np.full(len(ended), None, dtype=object)
    for i in np.flatnonzero(ended).tolist():
        final[i] = row(observation, i)
    values = {name: np.where(ended, value, False) for name, value in infos.items()}
    return {
        "final_obs": final,
        "_final_obs": ended.copy(),
        "final_info": values,
        "_final_info": ended.copy(),
    }


def _action_space(copies: Copies) -> spaces.Box:
    return spaces.Box(-1.0, 1.0, (len(copies.actions.names),), np.float32)


def _goal_rewards(
    copies: Copies, achieved: ArrayLike, desired: ArrayLike
) -> Array | np.float64:
    width = len(copies.task.goal_names)
    goals = [np.asarray(goal, dtype=np.float64) for goal in (achieved, desired)]
    for goal in goals:
        if goal.shape[-1:] != (width,):
            raise ControlError(
                f"a goal has shape {goal.shape}; it must be (…, {width}) for "
                f"{', '.join(copies.task.goal_names)}"
            )
    found = copies.goal_rewards(*goals)
    return found if found.ndim else np.float64(found)


def _checked_render_mode(mode: str | None) -> str | None:
    if mode is not None and mode not in RENDER_MODES:
        raise ConfigError(
            f"render_mode must be rgb_array or None, got {mode!r}; to watch, write the "
            "images to a video, or bring up a robot with its panel"
        )
    return mode


def _checked_autoreset_mode(mode: str | AutoresetMode) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        names = ", ".join(item.value for item in AutoresetMode)
        raise ConfigError(
            f"autoreset_mode must be one of {names}; got {mode!r}"
        ) from None


def _seeds(seed: int | Sequence[int | None] | None, n: int) -> list[int | None]:
    if seed is None:
        return [None] * n
    if isinstance(seed, int | np.integer):
        return [int(seed) + i for i in range(n)]
    seeds = list(seed)
    if len(seeds) != n:
        raise ControlError(f"{len(seeds)} seeds for {n} copies; give one per copy")
    return seeds


def _reset_mask(options: Mapping[str, Any] | None, n: int) -> Mask:
    if options is None or "reset_mask" not in options:
        return np.ones(n, dtype=bool)
    mask = np.asarray(options["reset_mask"])
    if mask.shape != (n,) or mask.dtype != np.bool_:
        raise ControlError(
            f"reset_mask must be booleans of shape ({n},), got {mask.dtype} of shape "
            f"{mask.shape}"
        )
    return mask
