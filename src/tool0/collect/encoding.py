"""Encoding of episodes as files in the formats ``parquet`` and ``lerobot``."""

from __future__ import annotations

from typing import Any

import numpy as np

from tool0.collect import lerobot, parquet
from tool0.collect.rollout import Array, Episode
from tool0.collect.settings import Format


def encoded(episode: Episode, index: int, form: Format) -> tuple[dict[str, Any], bytes]:
    """Return an episode's row in the index, and the content of its file.

    In LeRobot's format, the frames in the file are numbered from 0; see
    ``lerobot.placed``.

    Raises:
        ConfigError: If the format does not support the episode's rate.
    """
    row: dict[str, Any] = {
        "episode_index": index,
        "seed": episode.seed,
        "length": episode.n_frames,
        "success": episode.success,
        "terminated": episode.terminated,
        "return": float(episode.rewards.sum()),
    }
    if form == "lerobot":
        return row, lerobot.encoded(episode, index)
    return row, parquet.file_of(parquet.table(_columns(episode, index)))


def _columns(episode: Episode, index: int) -> dict[str, Array]:
    n = episode.n_frames
    ends = np.arange(n) == n - 1
    return {
        **{
            f"observation.{name}" if name else "observation": values
            for name, values in episode.observations.items()
        },
        "action": episode.actions,
        "reward": episode.rewards,
        "terminated": ends & episode.terminated,
        "truncated": ends & (not episode.terminated),
        "success": ends & episode.success,
        "timestamp": (np.arange(n) / episode.rate).astype(np.float32),
        "frame_index": np.arange(n),
        "episode_index": np.full(n, index),
    }
