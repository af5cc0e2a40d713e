"""Policies that are Python functions or classes, as in ``tool0 collect``."""

from __future__ import annotations

from typing import Any, final

from tool0.collect.policy import Act, Policy, loaded, located
from tool0.errors import PolicyError, Tool0Error
from tool0.policy.seen import Seen


@final
class CallablePolicy:
    """A callable that maps a seed to a function from observation to actions."""

    def __init__(self, policy: str | Policy) -> None:
        """Use the given function or class, or load it by name.

        Raises:
            ConfigError: If there is no such policy, or its file raises an error.
        """
        self.digest: str | None = None
        self._name = name_of(policy)
        if isinstance(policy, str):
            self._name, self.digest = located(policy)
            self._policy = loaded(self._name, self.digest)
        else:
            self._policy = policy
        self._act: Act | None = None

    def begin(self, seed: int) -> None:
        """Begin an episode."""
        self._act = self._call(self._policy, seed)

    def infer(self, seen: Seen) -> Any:
        """Return the actions that the policy's function computes.

        Raises:
            PolicyError: If the function raises an error.
        """
        assert self._act is not None
        return self._call(self._act, seen.observation)

    def close(self) -> None:
        """Discard the function of the current episode."""
        self._act = None

    def _call(self, function: Any, argument: Any) -> Any:
        try:
            return function(argument)
        except Tool0Error:
            raise
        except Exception as error:  # raised by the user's code
            place = _place(error)
            reason = f"{type(error).__name__}: {error}"
            raise PolicyError(f"policy '{self._name}': {place}{reason}") from error


def name_of(policy: str | Policy) -> str:
    """Return the name of a policy, for messages and reports."""
    if isinstance(policy, str):
        return policy
    return str(getattr(policy, "__qualname__", type(policy).__qualname__))


def _place(error: Exception) -> str:
    """Return the file and line where an error was raised, followed by a colon."""
    trace, place = error.__traceback__, ""
    while trace is not None:
        place = f"{trace.tb_frame.f_code.co_filename}:{trace.tb_lineno}: "
        trace = trace.tb_next
    return place
