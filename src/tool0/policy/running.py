"""Execution of one episode of a policy, with a recording of the results."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any, Final, Literal, final

from tool0.collect.rollout import Episode, Recorder
from tool0.errors import ConfigError
from tool0.policy.chunks import ChunkOptions, Chunks
from tool0.policy.environment import (
    ActionRefusedError,
    Array,
    Environment,
    Outcome,
    Picture,
    within_limits,
)
from tool0.policy.seen import Seen
from tool0.policy.source import Source, checked_chunk

Result = Literal["success", "failure", "ended", "stopped", "interrupted"]
"""Result of an episode.  ``ended`` means that it is unknown whether the episode
succeeded."""
Latency = float | Literal["measured"]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """Options for executing a policy."""

    chunks: ChunkOptions = ChunkOptions()
    """Options for executing chunks of actions."""
    latency: Latency = 0.0
    """Simulated time between an observation and its actions, if time is paused while
    the policy computes [s]; ``measured`` selects the wall time of each answer."""
    clips: bool = False
    """Whether to clip actions that are far beyond the limits; otherwise, such an action
    ends the episode."""
    max_steps: int | None = None
    """Number of actions after which the episode ends; None for no limit."""

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            ConfigError: If a value is out of range.
        """
        if self.latency != "measured" and not 0.0 <= self.latency <= 10.0:
            raise ConfigError(f"latency must be 0 … 10 s, got {self.latency}")
        if self.max_steps is not None and self.max_steps < 1:
            raise ConfigError(f"an episode needs a step, got {self.max_steps}")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeRun:
    """Result of one episode."""

    seed: int
    result: Result
    reason: str = ""
    """Reason why the episode was stopped; empty if it was not stopped."""
    n_steps: int
    """Number of executed actions."""
    total_reward: float
    latencies: tuple[float, ...]
    """Wall time of each of the policy's answers [s]."""
    n_held: int
    """Number of steps without an action, in which the robot held its position."""
    episode: Episode | None = field(repr=False, default=None)
    """Observations and actions of the episode; None if it ended before the first
    action."""
    pictures: tuple[Picture, ...] = field(repr=False, default=())
    """Images for a video, one before each action."""


def run_episode(
    environment: Environment,
    policy: Source,
    seed: int,
    options: RunOptions = RunOptions(),
    *,
    should_stop: Callable[[], bool] = lambda: False,
) -> EpisodeRun:
    """Execute a policy until the episode ends, and stop all motion.

    Raises:
        PolicyError: If the policy fails, or one of its answers has a wrong shape.
        TransportError: If the policy's server does not answer.
        ControlError: If the robot rejects an action.
    """
    policy.begin(seed)
    environment.begin(seed)
    try:
        return _Run(environment, policy, seed, options, should_stop).run()
    finally:
        environment.end()


_RESULTS: Final[Mapping[bool | None, Result]] = {
    True: "success",
    False: "failure",
    None: "ended",
}


@final
class _Run:
    def __init__(
        self,
        environment: Environment,
        policy: Source,
        seed: int,
        options: RunOptions,
        should_stop: Callable[[], bool],
    ) -> None:
        self._environment, self._seed, self._options = environment, seed, options
        self._should_stop = should_stop
        self._chunks = Chunks(options.chunks)
        asks = _InTime if environment.is_realtime else _OutOfTime
        self._answers: _InTime | _OutOfTime = asks(policy, environment, options)
        self._recorder = Recorder(seed, None)
        self._pictures: list[Picture] = []
        self._n_held = self._n_steps = 0
        self._reward = 0.0

    def run(self) -> EpisodeRun:
        outcome, reason = Outcome(), ""
        result: Result | None = None
        limit = self._options.max_steps or math.inf
        try:
            while not (outcome.terminated or outcome.truncated):
                if self._should_stop():
                    result, reason = "interrupted", "stopped by the user"
                    break
                if self._n_steps >= limit:
                    break
                outcome = self._step()
        except ActionRefusedError as error:
            result, reason = "stopped", f"in step {self._n_steps}: {error}"
        if result is None or outcome.success:
            result = _RESULTS[outcome.success]
        return self._found(outcome, result, reason)

    def _step(self) -> Outcome:
        environment, step = self._environment, self._n_steps
        seen = environment.see()
        self._take(step)
        if self._chunks.wants(step):
            self._chunks.ask(step)
            self._answers.ask(seen, step)
            self._take(step)
        action = self._chunks.action(step)
        if action is None:
            action = environment.hold()
            self._n_held += 1
        else:
            action = within_limits(action, environment, clips=self._options.clips)
        picture = environment.picture()
        if picture is not None:
            self._pictures.append(picture)
        outcome = environment.act(action)
        self._recorder.add(seen.kept, action, outcome.reward)
        self._n_steps += 1
        self._reward += outcome.reward
        return outcome

    def _take(self, step: int) -> None:
        """Add a chunk that has been received by this step."""
        chunk = self._answers.arrived(step)
        if chunk is not None:
            self._chunks.add(chunk, step)

    def _found(self, outcome: Outcome, result: Result, reason: str) -> EpisodeRun:
        episode = None
        if self._n_steps:
            episode = self._recorder.episode(
                outcome.terminated, result == "success", self._environment.rate
            )
        return EpisodeRun(
            seed=self._seed,
            result=result,
            reason=reason,
            n_steps=self._n_steps,
            total_reward=self._reward,
            latencies=tuple(self._answers.latencies),
            n_held=self._n_held,
            episode=episode,
            pictures=tuple(self._pictures),
        )


@final
class _OutOfTime:
    """Queries of a policy while time is paused; answers are used after the latency."""

    def __init__(
        self, policy: Source, environment: Environment, options: RunOptions
    ) -> None:
        self._policy, self._rate = policy, environment.rate
        self._width = len(environment.action_names)
        self._latency = options.latency
        self.latencies: list[float] = []
        self._answer: tuple[int, Array] | None = None
        """Step at which the chunk is available, and the chunk."""

    def ask(self, seen: Seen, step: int) -> None:
        start = time.perf_counter()
        chunk = checked_chunk(self._policy.infer(seen), self._width)
        self.latencies.append(time.perf_counter() - start)
        latency = self._latency
        delay = self.latencies[-1] if latency == "measured" else latency
        self._answer = step + math.ceil(delay * self._rate - 1e-9), chunk

    def arrived(self, step: int) -> Array | None:
        if self._answer is None or self._answer[0] > step:
            return None
        chunk, self._answer = self._answer[1], None
        return chunk


@final
class _InTime:
    """Queries of a policy in a separate thread while time continues."""

    def __init__(
        self, policy: Source, environment: Environment, options: RunOptions
    ) -> None:
        self._policy = policy
        self._width = len(environment.action_names)
        self.latencies: list[float] = []
        self._pending: Future[tuple[Any, float]] | None = None
        """Pending answer, with the wall time of its computation [s]."""

    def ask(self, seen: Seen, step: int) -> None:
        pending: Future[tuple[Any, float]] = Future()

        def infer() -> None:
            start = time.perf_counter()
            try:
                answer = self._policy.infer(seen)
            except BaseException as error:  # raised in the waiting thread
                pending.set_exception(error)
            else:
                pending.set_result((answer, time.perf_counter() - start))

        self._pending = pending
        # The thread is a daemon, so a blocked policy does not prevent the process from
        # ending.
        threading.Thread(target=infer, name="policy", daemon=True).start()

    def arrived(self, step: int) -> Array | None:
        if self._pending is None or not self._pending.done():
            return None
        answer, latency = self._pending.result()
        self._pending = None
        self.latencies.append(latency)
        return checked_chunk(answer, self._width)
