"""Chunks of actions: when the next is asked for, and which action is next."""

from __future__ import annotations

import math

import numpy as np
import pytest
from raises_naming import raises_naming

from tool0.errors import ConfigError
from tool0.policy.chunks import ChunkOptions, Chunks


def chunk_from(step: int, length: int = 4) -> np.ndarray:
    """Return a chunk whose actions are the steps that they are meant for."""
    return np.arange(step, step + length, dtype=float)[:, None]


def executed(
    options: ChunkOptions, n_steps: int, delay: int = 0, length: int = 4
) -> tuple[list[float | None], list[int]]:
    """Return the actions of each step, and the steps in which a chunk was asked for."""
    chunks, actions, asked = Chunks(options), [], []
    arrival: int | None = None
    for step in range(n_steps):
        for _ in range(2):  # one that arrives lets the next be asked for
            if asked and arrival == step:
                chunks.add(chunk_from(asked[-1], length), step)
                arrival = None
            if chunks.wants(step):
                chunks.ask(step)
                asked.append(step)
                arrival = step + delay
        action = chunks.action(step)
        actions.append(None if action is None else float(action[0]))
    return actions, asked


def test_a_chunk_is_executed_to_its_end() -> None:
    actions, asked = executed(ChunkOptions(), 8)
    assert actions == list(range(8))
    assert asked == [0, 4]


def test_a_part_of_a_chunk_can_be_executed() -> None:
    actions, asked = executed(ChunkOptions(execute=2), 6)
    assert actions == list(range(6))
    assert asked == [0, 2, 4]


def test_late_actions_are_skipped_and_the_next_chunk_is_asked_for_earlier() -> None:
    actions, asked = executed(ChunkOptions(), 9, delay=2)
    assert actions[:2] == [None, None]
    assert actions[2:] == list(range(2, 9))  # each at the step that it was meant for
    assert asked == [0, 2, 4, 6, 8]


def test_late_actions_can_be_executed_late() -> None:
    actions, _ = executed(ChunkOptions(compensate=False), 6, delay=2)
    assert actions == [None, None, 0.0, 1.0, 2.0, 3.0]


def test_a_chunk_that_is_late_as_a_whole_gives_nothing() -> None:
    actions, _ = executed(ChunkOptions(), 12, delay=4)
    assert actions == [None] * 12


def test_an_ensemble_is_the_weighted_mean_of_all_predictions() -> None:
    chunks = Chunks(ChunkOptions(ensemble=0.5))
    for step, level in enumerate((0.0, 1.0, 5.0)):
        assert chunks.wants(step)
        chunks.ask(step)
        chunks.add(np.full((3, 1), level), step)
        action = chunks.action(step)
    weights = [1.0, math.exp(-0.5), math.exp(-1.0)]  # of the oldest first
    mean = (weights[1] * 1.0 + weights[2] * 5.0) / sum(weights)
    assert action is not None
    assert action[0] == pytest.approx(mean)


@pytest.mark.parametrize(
    ("options", "shown"),
    [
        ({"execute": 0}, "execute must be 1 or more"),
        ({"ensemble": -1.0}, "ensemble must be 0 or more"),
        ({"ensemble": 0.1, "execute": 3}, "leave out execute"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, float], shown: str) -> None:
    with raises_naming(ConfigError, shown):
        ChunkOptions(**options)  # type: ignore[arg-type]  # wrong on purpose
