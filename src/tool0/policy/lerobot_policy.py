"""Pretrained LeRobot policies, which run in this process with LeRobot's code.

Loading and inference follow lerobot 0.6 (lerobot/async_inference/policy_server.py,
https://github.com/huggingface/lerobot).
"""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import Any, final

import numpy as np

from tool0.errors import ConfigError, PolicyError
from tool0.policy.seen import Seen


@final
class LeRobotPolicy:
    """Policy from ``lerobot-train``, in ``…/checkpoints/last/pretrained_model``."""

    digest = None

    def __init__(self, folder: str, device: str) -> None:
        """Load the policy onto a device.

        Raises:
            ConfigError: If LeRobot is not installed, or there is no such folder.
            PolicyError: If LeRobot cannot load the policy.
        """
        try:
            import torch
            from lerobot.configs.policies import PreTrainedConfig
            from lerobot.policies.factory import (
                get_policy_class,
                make_pre_post_processors,
            )
        except ImportError as error:
            raise ConfigError(
                f"a LeRobot policy needs lerobot in this environment: {error}; see "
                "docs/how-to/policies.md"
            ) from None
        path = Path(folder)
        if not (path / "config.json").is_file():
            raise ConfigError(
                f"policy '{folder}': there is no config.json; give the folder "
                "pretrained_model of a checkpoint"
            )
        self._torch = torch
        try:
            config = PreTrainedConfig.from_pretrained(path)
            config.device = device
            with contextlib.redirect_stdout(sys.stderr):  # LeRobot prints messages
                self._policy = get_policy_class(config.type).from_pretrained(
                    path, config=config
                )
            self._before, self._after = make_pre_post_processors(
                config,
                pretrained_path=str(path),
                preprocessor_overrides={"device_processor": {"device": device}},
            )
        except Exception as error:  # LeRobot may raise any error
            raise _failed(folder, error) from error
        self._policy.eval()
        self._folder = folder
        self._wanted = [*config.input_features]
        self._has_queues = getattr(config, "n_obs_steps", 1) > 1

    def begin(self, seed: int) -> None:
        """Begin an episode; the seed determines the policy's random numbers."""
        self._torch.manual_seed(seed)
        for each in (self._policy, self._before, self._after):
            each.reset()

    def infer(self, seen: Seen) -> Any:
        """Return a chunk of actions, shape (h, m).

        Raises:
            PolicyError: If the observation lacks an input of the policy, or LeRobot
                fails.
        """
        columns = seen.columns()
        missing = [name for name in self._wanted if name not in columns]
        if missing:
            raise PolicyError(
                f"policy '{self._folder}' wants {', '.join(missing)}; observed are "
                f"{', '.join(columns)}"
            )
        torch = self._torch
        inputs: dict[str, Any] = {
            name: _tensor(torch, columns[name]) for name in self._wanted
        }
        inputs["task"] = seen.instruction
        try:
            with torch.inference_mode():
                ready = self._before(inputs)
                if self._has_queues:  # the policy stores past observations
                    return self._after(self._policy.select_action(ready)).cpu().numpy()
                chunk = self._policy.predict_action_chunk(ready)
                return self._after(chunk[0]).cpu().numpy()
        except Exception as error:  # LeRobot may raise any error
            raise _failed(self._folder, error) from error

    def close(self) -> None:
        """Do nothing, because the policy has no connections."""


def _tensor(torch: Any, values: np.ndarray[Any, Any]) -> Any:
    """Return numbers unchanged, and images in LeRobot's form (3, h, w) within 0 … 1."""
    if values.dtype == np.uint8:
        values = np.moveaxis(values, -1, 0).astype(np.float32) / np.float32(255.0)
    return torch.from_numpy(np.ascontiguousarray(values))


def _failed(folder: str, error: Exception) -> PolicyError:
    reason = f"{type(error).__name__}: {error}"
    return PolicyError(f"policy '{folder}': LeRobot: {reason}")
