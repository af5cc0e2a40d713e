"""Episodes of a task, from copies of its environment that are stepped together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from tool0.collect.policy import Act, Policy
from tool0.collect.tasks import environment_spec
from tool0.errors import CollectError, ConfigError

Array = NDArray[Any]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """One episode from its reset to its end, with one row per action."""

    seed: int
    observations: Mapping[str, Array]
    """Observations before each action, shape (n_frames, …), by name; the name is ``""``
    if there is only one observation."""
    actions: Array
    """Actions, shape (n_frames, n)."""
    rewards: Array
    """Rewards, shape (n_frames,)."""
    terminated: bool
    """Whether the task ended the episode; otherwise, the time limit was reached."""
    success: bool
    rate: float
    """Actions per simulated second [Hz]."""
    names: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Names of the components, if they have names; the key is the name of the
    observation, or ``action``."""
    surroundings: frozenset[str] = frozenset()
    """Names of the components that describe the surroundings of the robot."""

    @property
    def n_frames(self) -> int:
        return len(self.rewards)


@final
class Rollout(AbstractContextManager["Rollout"]):
    """Copies of a task's environment, which execute independent episodes."""

    def __init__(
        self,
        task: str,
        options: Mapping[str, Any],
        policy: Policy | None,
        n_copies: int,
        *,
        digest: str | None = None,
    ) -> None:
        """Create the environments; if ``policy`` is None, the task's expert is used.

        ``digest`` is the SHA-256 of the file that defines the task, or None if there is
        no such file.

        Raises:
            ConfigError: If there is no such task, or the required expert does not
                exist.
        """
        import gymnasium

        from tool0.gym.registration import task_of

        spec = environment_spec(task, digest)
        given = dict(options)
        if task_of(spec) is not None:
            given.setdefault("threads", 1)  # other workers use the other processors
        mode = {"autoreset_mode": gymnasium.vector.AutoresetMode.DISABLED}
        given |= mode if spec.vector_entry_point else {"vector_kwargs": mode}
        self._envs: Any = gymnasium.make_vec(spec, num_envs=n_copies, **given)
        self._policy = policy
        self._expert = None if policy else _expert(self._envs)
        self._n_copies = n_copies
        rate = self._envs.metadata.get("render_fps")
        if not rate:
            raise ConfigError(f"task '{task}': its metadata lack render_fps [Hz]")
        self._rate = float(rate)
        self._names = getattr(self._envs.unwrapped, "number_names", None)

    def __exit__(self, *_: object) -> None:
        """Close the environments."""
        self._envs.close()

    def episodes(self, seeds: Iterable[int]) -> Iterator[Episode]:
        """Yield the episode of each seed, in the order in which the episodes end.

        A copy whose episode has ended starts an episode with the next seed.
        """
        waiting = iter(seeds)
        running: dict[int, Recorder] = {}
        seed_of = [0] * self._n_copies
        ended = np.ones(self._n_copies, bool)
        while True:
            for copy in np.flatnonzero(ended).tolist():
                seed = next(waiting, None)
                if seed is not None:
                    seed_of[copy] = seed
                    act = None if self._policy is None else self._policy(seed)
                    running[copy] = Recorder(seed, act)
            if not running:
                return
            if ended.any():  # a copy without a new seed repeats its last episode
                observations, _ = self._envs.reset(
                    seed=list(seed_of), options={"reset_mask": ended}
                )
            seen = {copy: _of(observations, copy) for copy in running}
            actions = self._actions(seen, running)
            observations, rewards, terminated, truncated, info = self._envs.step(
                actions
            )
            ended = terminated | truncated
            for copy, recorder in list(running.items()):
                recorder.add(seen[copy], actions[copy], rewards[copy])
                if ended[copy]:
                    del running[copy]
                    success = bool(info.get("is_success", ended & False)[copy])
                    episode = recorder.episode(
                        bool(terminated[copy]), success, self._rate
                    )
                    yield self._named(episode)

    def _named(self, episode: Episode) -> Episode:
        """Return the episode with the component names that the environment defines."""
        if self._names is None:
            return episode
        return replace(
            episode,
            names={**self._names.observations, "action": self._names.action},
            surroundings=self._names.surroundings,
        )

    def _actions(
        self, seen: Mapping[int, Any], running: Mapping[int, Recorder]
    ) -> Array:
        space = self._envs.action_space
        if self._expert is not None:
            return np.asarray(self._expert(), space.dtype)
        actions = np.zeros(space.shape, space.dtype)
        for copy, recorder in running.items():
            action = np.asarray(recorder.act(seen[copy]), space.dtype)
            if action.shape != space.shape[1:] or not np.isfinite(action).all():
                raise CollectError(
                    f"the policy returned {action} for seed {recorder.seed}: need "
                    f"finite numbers of shape {space.shape[1:]}"
                )
            actions[copy] = action
        return np.asarray(actions)


def _expert(envs: Any) -> Callable[[], Array]:
    from tool0.gym import expert

    found: Callable[[], Array] = expert(envs)
    return found


def _of(observations: Any, copy: int) -> Any:
    """Return the observation of one copy: an array, or a dictionary of arrays."""
    if isinstance(observations, dict):
        return {name: _of(value, copy) for name, value in observations.items()}
    return np.array(observations[copy])


def flat(observation: Any, name: str = "") -> Iterator[tuple[str, Array]]:
    """Yield the names and arrays of an observation; nested names are joined by dots."""
    if not isinstance(observation, dict):
        yield name, observation
        return
    for key, value in observation.items():
        yield from flat(value, f"{name}.{key}" if name else key)


@final
class Recorder:
    """Recorder of the frames of one episode."""

    def __init__(self, seed: int, act: Act | None) -> None:
        self.seed = seed
        self._act = act
        self._frames: list[tuple[dict[str, Array], Array, float]] = []

    def act(self, observation: Any) -> Any:
        assert self._act is not None
        return self._act(observation)

    def add(self, observation: Any, action: Array, reward: float) -> None:
        self._frames.append((dict(flat(observation)), action.copy(), reward))

    def episode(self, terminated: bool, success: bool, rate: float) -> Episode:
        observations, actions, rewards = zip(*self._frames, strict=True)
        return Episode(
            seed=self.seed,
            observations={
                name: np.stack([frame[name] for frame in observations])
                for name in observations[0]
            },
            actions=np.stack(actions),
            rewards=np.array(rewards, float),
            terminated=terminated,
            success=success,
            rate=rate,
        )
