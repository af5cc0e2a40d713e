"""Policies that are named functions or classes in modules or files.

A policy is called with an episode's seed and returns a function from an observation to
an action.  A policy can therefore keep state during an episode, but not between
episodes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

from tool0.collect.user_files import cannot_load, is_file, located_file, run_file
from tool0.errors import ConfigError, did_you_mean

Act = Callable[[Any], Any]
"""Function from the observation of one environment to an action."""
Policy = Callable[[int], Act]
"""Callable that returns the function ``Act`` for the seed of an episode."""


def located(policy: str | Policy) -> tuple[str, str | None]:
    """Return the full name of a policy, and the SHA-256 of its file, if it has one.

    Workers load the policy by this name.  Neither code nor pickled objects are sent.

    Raises:
        ConfigError: If there is no such policy, or a callable cannot be found by its
            name.
    """
    name = policy if isinstance(policy, str) else _name_of(policy)
    place, colon, attribute = name.rpartition(":")
    if not (place and colon and attribute):
        raise ConfigError(
            f"policy '{name}': write module:name or file.py:name, such as "
            "my_policy.py:Policy"
        )
    digest = None
    if is_file(name):
        name, digest = located_file(name, "policy")
    loaded(name, digest)
    return name, digest


def loaded(name: str, digest: str | None) -> Policy:
    """Load the policy that ``located`` found.

    Raises:
        ConfigError: If there is no such policy, or the digest of its file differs.
    """
    place, _, attribute = name.rpartition(":")
    try:
        if digest is None:
            values = vars(import_module(place))
        else:
            values = run_file(name, digest, "policy")
    except ConfigError:
        raise
    except Exception as error:  # raised by the user's code
        raise cannot_load(name, "policy", error) from error
    if not callable(policy := values.get(attribute)):
        names = [key for key, value in values.items() if callable(value)]
        hint = did_you_mean(attribute, names)
        raise ConfigError(f"policy '{name}': no function or class '{attribute}'{hint}")
    found: Policy = policy
    return found


def _name_of(policy: Policy) -> str:
    module = getattr(policy, "__module__", None)
    attribute = getattr(policy, "__qualname__", "")
    home = sys.modules.get(module or "")
    if home is None or getattr(home, attribute, None) is not policy:
        raise ConfigError(
            f"policy {policy!r}: workers find a policy by its name, so it must be a "
            "function or class at the top level of a module"
        )
    if module == "__main__":
        module = getattr(home, "__file__", None)
        if module is None:
            raise ConfigError(
                f"policy '{attribute}' was typed into an interpreter, where workers do "
                "not find it: write it into a file"
            )
    return f"{module}:{attribute}"
