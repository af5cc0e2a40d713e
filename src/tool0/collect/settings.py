"""Settings and programs that determine the content of an episode's file."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any, Final, Literal, final

import numpy as np

from tool0.errors import ConfigError

Format = Literal["parquet", "lerobot"]
"""Format of a data set, which determines the columns and the additional files."""

_LIBRARIES: Final = ("gymnasium", "pyarrow")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """The parameters of a data set; with an index, they define an episode."""

    task: str
    """Name of the task, or id of a Gymnasium environment with its module or file."""
    task_digest: str | None
    """SHA-256 of the file that defines the task; None if there is no such file."""
    options: Mapping[str, Any]
    """Keyword arguments of the environment, as JSON values."""
    seed: int
    """Base from which the episodes' seeds are derived."""
    policy: str | None
    """Policy as ``module:name`` or ``file.py:name``; None for the expert."""
    digest: str | None
    """SHA-256 of the file that defines the policy; None if there is no such file."""
    format: Format
    instruction: str
    """Description of the task, which only LeRobot's format contains."""

    def to_json(self) -> dict[str, Any]:
        """Return the settings as JSON values; ``from_json`` is the inverse function."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Settings:
        """Return the settings from the values that ``to_json`` returned."""
        return cls(**values)

    def recorded(self) -> dict[str, Any]:
        """Return the values for the manifest, in which digests replace file paths."""
        policy, task = self.policy, self.task
        if self.digest is not None and policy is not None:
            policy = f"{policy.rpartition(':')[2]}@sha256:{self.digest}"
        if self.task_digest is not None:
            task = f"{task.rpartition(':')[2]}@sha256:{self.task_digest}"
        values = {
            "task": task,
            "options": dict(self.options),
            "seed": self.seed,
            "policy": policy,
            "format": self.format,
        }
        if self.format == "lerobot":
            values["instruction"] = self.instruction
        return values


def episode_seed(base: int, index: int) -> int:
    """Return the seed of an episode, below 2**63, from ``base`` and ``index`` alone."""
    state = np.random.SeedSequence([base, index]).generate_state(1, np.uint64)
    return int(state[0]) >> 1


def require_extra() -> None:
    """Raise ConfigError if a library of the extra ``collect`` is not installed."""
    for name in _LIBRARIES:
        if importlib.util.find_spec(name) is None:
            raise ConfigError(
                f"a data set needs {name}, which is not installed; run "
                "pip install '.[collect]'"
            )


@cache
def programs() -> dict[str, str]:
    """Return versions and an arithmetic digest that determine this machine's episodes.

    If these values are equal on two machines, the same seeds give the same bytes on
    both machines.
    """
    from importlib.metadata import version

    from tool0.simulation.provenance import batch_versions, kernel_digest

    libraries = {name: version(name) for name in _LIBRARIES}
    computed = {"kernel": kernel_digest(), "arithmetic": _arithmetic()}
    return batch_versions() | libraries | computed


def _arithmetic() -> str:
    """Return a digest of floating-point results, which depend on the processor.

    The C library and NumPy choose implementations for the processor when they are
    loaded, which affects the last bits of the results.
    """
    import math

    angles = np.linspace(-20.0, 20.0, 999)
    plain = [f(x) for x in angles for f in (math.sin, math.cos, math.atan, math.exp)]
    matrix = np.outer(np.sin(angles[:36]), np.cos(angles[:36]))
    parts = [
        np.array(plain),
        *(f(angles) for f in (np.sin, np.cos, np.exp, np.arctan)),
        *(matrix @ matrix, np.linalg.inv(matrix + np.eye(36))),
    ]
    digest = hashlib.sha256(b"".join(part.tobytes() for part in parts))
    return digest.hexdigest()[:16]


def differences(ours: Mapping[str, Any], theirs: Mapping[str, Any]) -> list[str]:
    """Return a text ``name theirs instead of ours`` for each value that differs."""
    return [
        f"{name} {json.dumps(theirs.get(name))} instead of {json.dumps(ours.get(name))}"
        for name in sorted({*ours, *theirs})
        if ours.get(name) != theirs.get(name)
    ]
